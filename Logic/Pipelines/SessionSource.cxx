#include "Pipelines/SessionSource.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "Adapters/OpenCv/ImageSequence.h"
#include "Adapters/OpenCv/VideoSource.h"
#include "Core/Errors.h"

namespace kerf {
namespace {

constexpr int kReadOn = 30;  // so many frames ahead are reached sooner by reading than by placing

std::string In(const SessionFolder& session, const std::string& name) {
  return (std::filesystem::path(session.root) / name).string();
}

}  // namespace

SessionSource::SessionSource(const SessionFolder& session)
    : session_(session), frames_(ReadRecordedFrames(session.root)) {
  if (frames_.empty()) throw InputError(In(session, "frames.csv"), "", "no frame was recorded");
  if (!session.source.empty()) {
    video_ = OpenVideo(In(session, session.source));
    width_ = video_->Width();
    height_ = video_->Height();
  } else if (const auto first = ReadImageFile(In(session, "frames/000000.jpg"))) {
    width_ = first->width;
    height_ = first->height;
  } else {
    throw InputError(In(session, "frames/000000.jpg"), "", "cannot be read");
  }
}

SessionSource::~SessionSource() = default;
int SessionSource::Width() const { return width_; }
int SessionSource::Height() const { return height_; }
double SessionSource::FramesPerSecond() const { return session_.frames_per_second; }

std::optional<Frame> SessionSource::Next() {
  if (next_ >= frames_.size()) return std::nullopt;
  const RecordedFrame& recorded = frames_[next_];
  Frame frame;
  if (video_ && last_read_ && last_read_->index == recorded.source_frame) {
    frame = *last_read_;  // looked at once more
  } else if (video_) {
    do {
      std::optional<Frame> read = video_->Next();
      if (!read)
        throw InputError(In(session_, session_.source),
                         "frame " + std::to_string(recorded.source_frame),
                         "is missing: this is not the video that was recorded");
      frame = std::move(*read);
      video_next_ = frame.index + 1;
    } while (frame.index < recorded.source_frame);
    last_read_ = frame;
  } else {
    const std::string path = In(session_, fmt::format("frames/{:06d}.jpg", recorded.number));
    std::optional<Image> image = ReadImageFile(path);
    if (!image) throw InputError(path, "", "cannot be read");
    frame.image = std::make_shared<const Image>(std::move(*image));
  }
  frame.index = recorded.number;
  frame.time_s = recorded.time_s;
  ++next_;
  return frame;
}

void SessionSource::GoTo(int number, bool by_reading) {
  next_ = std::clamp(number, 0, FrameCount());
  if (!video_ || next_ >= frames_.size()) return;
  const int wanted = frames_[next_].source_frame;
  const bool ahead = wanted >= video_next_ && wanted < video_next_ + kReadOn;
  if (ahead && !by_reading) return;
  if (!by_reading && video_->GoTo(wanted)) {
    video_next_ = wanted;
  } else if (by_reading || wanted < video_next_) {
    video_ = OpenVideo(In(session_, session_.source));
    video_next_ = 0;
  }
}

}  // namespace kerf
