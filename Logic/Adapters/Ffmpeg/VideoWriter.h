#pragma once

#include <memory>
#include <string>

#include "Core/Frame.h"

namespace kerf {

/// Writes an H.264 mp4 (4:2:0, plays anywhere). The same frames give the same file, whatever the
/// machine's cores. The file appears under its name only when it is complete: until Finish it is
/// `<name>.part.mp4`, which is removed when the writer is destroyed without Finish. H.264 with
/// 4:2:0 needs even sizes: an odd last column or row is dropped.
class VideoWriter {
 public:
  /// @throws InputError when neither H.264 nor MPEG-4 can be written there
  VideoWriter(const std::string& path, int width, int height, double frames_per_second);
  ~VideoWriter();
  VideoWriter(const VideoWriter&) = delete;
  VideoWriter& operator=(const VideoWriter&) = delete;

  /// @param image BGR or grey, of the writer's size. @throws InputError naming the frame when the
  /// size or the channels differ or it cannot be written (a full disk)
  void Write(const Image& image);
  /// Completes the file and gives it its name. @throws InputError when it could not be completed
  void Finish();
  int FrameCount() const;
  /// Worth telling: another codec had to be used; empty when all is as wanted.
  const std::string& Message() const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace kerf
