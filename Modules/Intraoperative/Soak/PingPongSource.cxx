#include "PingPongSource.h"

#include "Adapters/OpenCv/VideoSource.h"

namespace kerf {

PingPongSource::PingPongSource(const std::string& path, double frames_per_second, int most_frames) {
  const auto video = OpenVideo(path);
  frames_per_second_ = frames_per_second > 0 ? frames_per_second : video->FramesPerSecond();
  while (static_cast<int>(frames_.size()) < most_frames) {
    const auto frame = video->Next();
    if (!frame) break;
    frames_.push_back(frame->image);
  }
}

std::optional<Frame> PingPongSource::Next() {
  const int n = static_cast<int>(frames_.size());
  const int period = 2 * (n - 1);
  const int at = next_ % period;
  Frame frame;
  frame.index = next_++;
  frame.time_s = frame.index / frames_per_second_;
  frame.image = frames_[at < n ? at : period - at];
  return frame;
}

}  // namespace kerf
