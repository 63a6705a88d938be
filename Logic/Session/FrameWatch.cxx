#include "Session/FrameWatch.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace kerf {
namespace {

constexpr double kFrozen_s = 0.5;            // a picture that stands still for as long
constexpr double kLeap_mm = 5.0;             // a step of all features from one frame to the next,
constexpr double kFastestTissue_mm_s = 150;  // and as fast as only a camera moves
constexpr double kLeapDoubt_s = 1.0;  // for as long after it the gate is no better than amber
constexpr double kDoubtfulScore = 0.35;
// Fewer pictures a second than this and cuts were missed on recorded studies
// (docs/reference/tracking.md); over so many intervals, and as long in doubt after it.
constexpr double kSparse = 3.0;
constexpr std::size_t kIntervals = 3;
constexpr double kSparseDoubt_s = 1.0;

/// A gate that is amber already keeps its reason: that is found in the picture itself.
void LimitToAmber(const std::string& reason, Reliability* reliability) {
  if (reliability->state == GateState::Off) return;
  if (reliability->state == GateState::Green) reliability->reason = reason;
  reliability->state = GateState::Amber;
  reliability->score = std::min(reliability->score, kDoubtfulScore);
}

}  // namespace

/// A source that repeats one picture bit for bit, as no camera does, says nothing of the organ.
void FrameWatch::WatchPicture(const Frame& frame, Reliability* reliability) {
  if (!frame.image) return;
  if (!picture_ || frame.image->data != picture_->data) changed_s_ = frame.time_s;
  picture_ = frame.image;
  if (frame.time_s - changed_s_ >= kFrozen_s) LimitToAmber("the picture stands still", reliability);
}

/// Registration takes the camera to stand still (DESIGN: the pose is that of the start).
void FrameWatch::WatchLeap(double time_s, double leap_mm, Reliability* reliability) {
  const double passed_s = std::max(1e-3, time_s - last_s_);
  if (last_s_ >= 0.0 && leap_mm > kLeap_mm && leap_mm / passed_s > kFastestTissue_mm_s)
    leapt_s_ = time_s;
  last_s_ = time_s;
  if (leapt_s_ >= 0.0 && time_s - leapt_s_ < kLeapDoubt_s)
    LimitToAmber("everything leapt: has the camera moved?", reliability);
}

/// Between two pictures the tissue may go on by more than what tells a cut from a stretch.
void FrameWatch::WatchRate(double time_s, Reliability* reliability) {
  registered_s_.push_back(time_s);
  if (registered_s_.size() > kIntervals + 1) registered_s_.pop_front();
  const double passed_s = time_s - registered_s_.front();
  if (registered_s_.size() > kIntervals && passed_s * kSparse > kIntervals) {
    sparse_s_ = time_s;
    sparse_rate_ = kIntervals / passed_s;
  }
  if (sparse_s_ < 0.0 || time_s - sparse_s_ >= kSparseDoubt_s) return;
  // Whole pictures: rounded up it would name the rate that suffices.
  const int rate = static_cast<int>(std::floor(sparse_rate_));
  const std::string pictures = rate < 1
                                   ? "less than 1 picture"
                                   : std::to_string(rate) + (rate > 1 ? " pictures" : " picture");
  LimitToAmber(pictures + " a second registered: cuts may be missed", reliability);
}

}  // namespace kerf
