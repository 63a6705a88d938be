#pragma once

#include "Core/Frame.h"
#include "Pipelines/ReplayPipeline.h"
#include "Pipelines/SessionFolder.h"

namespace kerf {

/// The frames of a session as they were registered.
class SessionSource : public FrameSource {
 public:
  /// @throws InputError naming the file: nothing recorded, a video that is not the one of then
  explicit SessionSource(const SessionFolder& session);
  ~SessionSource() override;
  std::optional<Frame> Next() override;
  int Width() const override;
  int Height() const override;
  double FramesPerSecond() const override;
  int FrameCount() const override { return static_cast<int>(frames_.size()); }

 private:
  SessionFolder session_;
  std::vector<RecordedFrame> frames_;
  std::unique_ptr<FrameSource> video_;  ///< none where pictures were recorded one by one
  std::size_t next_ = 0;
  int width_ = 0, height_ = 0;
};

/// `kerf replay CASE/sessions/<time>`: the same frames, the same decisions between them, the same
/// bits; every frame's checksum is held against the recorded one.
/// @throws InputError; also when a checksum differs, naming the frame
ReplayResult ReplaySession(const ReplayRequest& request, Progress& progress);

}  // namespace kerf
