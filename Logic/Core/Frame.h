#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "Core/Types.h"

namespace kerf {

/// 8-bit image, rows top-down, interleaved BGR (3 channels) or grey (1 channel).
struct Image {
  int width = 0, height = 0, channels = 3;
  std::vector<std::uint8_t> data;
};

/// One video frame: raw (distorted) pixels, shared and constant.
struct Frame {
  int index = -1;
  double time_s = 0.0;
  std::shared_ptr<const Image> image;  ///< null where a study has no video
};

/// Where frames come from: a file, an image sequence, a camera, a synthetic scene in tests.
class FrameSource {
 public:
  virtual ~FrameSource() = default;
  /// Next frame in order, or none at the end. @throws InputError naming the source and the frame
  virtual std::optional<Frame> Next() = 0;
  virtual int Width() const = 0;
  virtual int Height() const = 0;
  virtual double FramesPerSecond() const = 0;
  /// Frames in all, or −1 where unknown (live).
  virtual int FrameCount() const = 0;
};

}  // namespace kerf
