#pragma once

#include <memory>
#include <optional>

#include "Core/Frame.h"
#include "Pipelines/SessionFolder.h"

namespace kerf {

class VideoSource;

/// The frames of a session as they were registered.
class SessionSource : public FrameSource {
 public:
  /// @throws InputError naming the file: nothing recorded, a video that is not the one of then
  explicit SessionSource(const SessionFolder& session);
  ~SessionSource() override;
  std::optional<Frame> Next() override;
  /// Goes to any frame; Next() reads it. Quick where the video can be placed.
  /// @param by_reading from the start of the video on: slow, but no container is believed
  void GoTo(int number, bool by_reading = false);
  int Width() const override;
  int Height() const override;
  double FramesPerSecond() const override;
  int FrameCount() const override { return static_cast<int>(frames_.size()); }
  const std::vector<RecordedFrame>& Frames() const { return frames_; }

 private:
  SessionFolder session_;
  std::vector<RecordedFrame> frames_;
  std::unique_ptr<VideoSource> video_;  ///< none where pictures were recorded one by one
  std::optional<Frame> last_read_;      ///< of `video_`
  int video_next_ = 0;                  ///< number of the frame that `video_` reads next
  std::size_t next_ = 0;
  int width_ = 0, height_ = 0;
};

}  // namespace kerf
