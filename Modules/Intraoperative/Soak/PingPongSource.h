#pragma once

#include <memory>
#include <string>
#include <vector>

#include "Core/Frame.h"

namespace kerf {

/// A recorded video played forwards and backwards for ever, as a live source would deliver it: no
/// jump where it turns. The first frames are decoded once and kept.
class PingPongSource : public FrameSource {
 public:
  /// @param frames_per_second 0: the video's own
  /// @param most_frames kept in memory (1.5 MB each at 960×540)
  explicit PingPongSource(const std::string& path, double frames_per_second = 0,
                          int most_frames = 300);
  std::optional<Frame> Next() override;
  int Width() const override { return frames_.front()->width; }
  int Height() const override { return frames_.front()->height; }
  double FramesPerSecond() const override { return frames_per_second_; }
  int FrameCount() const override { return -1; }

 private:
  std::vector<std::shared_ptr<const Image>> frames_;
  double frames_per_second_ = 25.0;
  int next_ = 0;
};

}  // namespace kerf
