#include "Adapters/OpenCv/LucasKanadeTracker.h"

#include <algorithm>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

#include "Adapters/OpenCv/CvMats.h"
#include "Adapters/OpenCv/FeatureDetection.h"
#include "Adapters/OpenCv/Masks.h"
#include "Adapters/OpenCv/NeighbourMotion.h"
#include "Adapters/OpenCv/PatchAligner.h"
#include "Adapters/OpenCv/TrackerImages.h"
#include "Core/Errors.h"

namespace kerf {
namespace {

cv::Point2f ToCv(const Eigen::Vector2f& p) { return {p.x(), p.y()}; }
Eigen::Vector2f FromCv(const cv::Point2f& p) { return {p.x, p.y}; }

/// What the tracker remembers of one feature.
struct FeatureTrack {
  Patch patch;
  AffineWarp warp;              ///< where it is (warp.t, full image px) and how it is deformed
  Eigen::Vector2f birth{0, 0};  ///< where it was taken
  FeatureStatus status = FeatureStatus::Lost;
  int alone = 0;  ///< frames since the reference patch was last recognized
  float correlation = 1;
};

class LucasKanadeTracker : public VideoTracker {
 public:
  explicit LucasKanadeTracker(const TrackerOptions& options) : options_(options) {
    if (options.window_px < 5 || options.levels < 0 || options.levels > 6 ||
        options.patch_half_px < 4 || options.patch_half_px > 40)
      throw UsageError("tracker: window, levels or patch size out of range");
    // An unknown name is refused now, not at the first frame.
    DetectInterestPoints(cv::Mat(64, 64, CV_8U, cv::Scalar(0)),
                         cv::Mat(64, 64, CV_8U, cv::Scalar(255)), options.detector);
  }

  FeatureSet Detect(const Frame& frame, const Image& organ_mask, int wanted) override {
    tracks_.clear();
    FeatureSet features;
    features.pixels.resize(0, 2);
    current_.Load(frame, MaskBox(frame, organ_mask), options_.window_px, options_.levels);
    Append(organ_mask, wanted, &features);
    return features;
  }

  void Adopt(const Frame& frame, const Image& organ_mask, FeatureSet* features) override {
    tracks_.assign(features->Size(), {});
    features->status.assign(features->Size(), FeatureStatus::Lost);
    cv::Rect box = PointBox(features->pixels);
    current_.Load(frame, box, options_.window_px, options_.levels);
    const cv::Mat excluded = Excluded(organ_mask);
    for (Index i = 0; i < features->Size(); ++i) {
      Start(features->pixels.row(i).cast<float>(), excluded, &tracks_[i]);
      features->status[i] = tracks_[i].status;
    }
    neighbours_.Build(Births());
  }

  int Replenish(const Image& organ_mask, int wanted, FeatureSet* features) override {
    CheckRows(*features);
    return Append(organ_mask, wanted, features);
  }

  void Predict(const Pixels& predicted_px) override { predicted_ = predicted_px; }

  void Track(const Frame& frame, FeatureSet* features) override {
    CheckRows(*features);
    std::swap(previous_, current_);
    current_.Load(frame, FollowedBox(), options_.window_px, options_.levels, previous_.Box());
    if (current_.Box() != previous_.Box())
      previous_.Reload(current_.Box(), options_.window_px, options_.levels);
    Follow();
    if (options_.neighbours) RefuseLoners();
    if (options_.recover) Recover();
    for (Index i = 0; i < features->Size(); ++i) {
      features->status[i] = tracks_[i].status;
      features->pixels.row(i) = tracks_[i].warp.t.cast<double>();
    }
    predicted_.resize(0, 2);
  }

 private:
  void CheckRows(const FeatureSet& features) const {
    if (static_cast<std::size_t>(features.Size()) != tracks_.size())
      throw UsageError("tracker: the features are not those of the last frame");
  }

  // ---- start
  // -------------------------------------------------------------------------------------------------------

  cv::Rect MaskBox(const Frame& frame, const Image& organ_mask) const {
    if (!frame.image) throw InputError("video", "frame " + std::to_string(frame.index), "no image");
    if (organ_mask.width != frame.image->width || organ_mask.height != frame.image->height ||
        organ_mask.channels != 1)
      throw InputError("organ mask", "", "its size is not the frame's");
    return cv::boundingRect(ViewOf(organ_mask));
  }
  static cv::Rect PointBox(const Pixels& pixels) {
    if (pixels.rows() == 0) return {};
    const Vec2 low = pixels.colwise().minCoeff(), high = pixels.colwise().maxCoeff();
    return cv::Rect(cv::Point(static_cast<int>(low.x()), static_cast<int>(low.y())),
                    cv::Point(static_cast<int>(high.x()) + 1, static_cast<int>(high.y()) + 1));
  }
  cv::Rect FollowedBox() const {
    Pixels pixels(static_cast<Index>(tracks_.size()), 2);
    Index n = 0;
    for (const FeatureTrack& track : tracks_)
      if (track.patch.Empty() == false) pixels.row(n++) = track.warp.t.cast<double>();
    return PointBox(pixels.topRows(n));
  }
  /// Highlights and instruments of the current frame and what is not organ, inside the current box.
  cv::Mat Excluded(const Image& organ_mask) const {
    cv::Mat excluded = current_.Excluded().clone();
    if (organ_mask.width > 0) excluded.setTo(255, ViewOf(organ_mask)(current_.Box()) == 0);
    return excluded;
  }
  void Start(const Eigen::Vector2f& pixel, const cv::Mat& excluded, FeatureTrack* track) const {
    track->birth = pixel;
    track->warp.t = pixel;
    if (track->patch.Take(current_.Smooth(), excluded, pixel - current_.Origin(),
                          options_.patch_half_px))
      track->status = FeatureStatus::Tracked;
  }
  std::vector<Eigen::Vector2f> Births() const {
    std::vector<Eigen::Vector2f> births;
    for (const FeatureTrack& track : tracks_) births.push_back(track.birth);
    return births;
  }

  int Append(const Image& organ_mask, int wanted, FeatureSet* features) {
    const cv::Mat excluded = Excluded(organ_mask);
    // A feature's centre keeps away from everything that is not plain tissue; its patch may reach
    // there.
    cv::Mat allowed;
    cv::erode(excluded == 0, allowed, cv::getStructuringElement(cv::MORPH_ELLIPSE, {9, 9}),
              {-1, -1}, 1, cv::BORDER_CONSTANT, cv::Scalar(0));
    cv::Mat texture;
    cv::cornerMinEigenVal(current_.Grey(), texture, 7, 3);
    allowed.setTo(0, texture < 2e-5);
    std::vector<InterestPoint> points =
        DetectInterestPoints(current_.Grey(), allowed, options_.detector);
    std::vector<cv::Point2f> taken;
    for (const FeatureTrack& track : tracks_)
      if (!track.patch.Empty()) taken.push_back(ToCv(track.warp.t - current_.Origin()));
    const int first_id =
        features->id.empty() ? 0 : *std::max_element(features->id.begin(), features->id.end()) + 1;
    std::vector<FeatureTrack> started;
    for (const InterestPoint& point :
         SpreadEvenly(std::move(points), wanted, taken, current_.Grey().size())) {
      FeatureTrack track;
      Start(Eigen::Vector2f(point.u, point.v) + current_.Origin(), excluded, &track);
      if (track.status == FeatureStatus::Tracked) started.push_back(std::move(track));
    }
    const Index old_rows = features->Size();
    features->pixels.conservativeResize(old_rows + static_cast<Index>(started.size()), 2);
    for (std::size_t i = 0; i < started.size(); ++i) {
      features->id.push_back(first_id + static_cast<int>(i));
      features->status.push_back(FeatureStatus::Tracked);
      features->pixels.row(old_rows + static_cast<Index>(i)) = started[i].warp.t.cast<double>();
      tracks_.push_back(std::move(started[i]));
    }
    neighbours_.Build(Births());
    return static_cast<int>(started.size());
  }

  // ---- one frame
  // ---------------------------------------------------------------------------------------------------

  /// Lucas–Kanade there and back, then the reference patch, for every feature that was seen in the
  /// last frame.
  void Follow() {
    std::vector<int> rows;
    std::vector<cv::Point2f> from, to, back;
    for (std::size_t i = 0; i < tracks_.size(); ++i)
      if (tracks_[i].status == FeatureStatus::Tracked) {
        rows.push_back(static_cast<int>(i));
        from.push_back(ToCv(tracks_[i].warp.t - current_.Origin()));
      }
    motion_.assign(tracks_.size(),
                   Eigen::Vector2f::Constant(std::numeric_limits<float>::quiet_NaN()));
    if (rows.empty()) return;
    std::vector<std::uint8_t> found, found_back;
    std::vector<float> ignored;
    const cv::Size window(options_.window_px, options_.window_px);
    const cv::TermCriteria until(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 20, 0.01);
    cv::calcOpticalFlowPyrLK(previous_.Pyramid(), current_.Pyramid(), from, to, found, ignored,
                             window, options_.levels, until, 0, 1e-4);
    cv::calcOpticalFlowPyrLK(current_.Pyramid(), previous_.Pyramid(), to, back, found_back, ignored,
                             window, options_.levels, until, 0, 1e-4);
    const float limit = static_cast<float>(options_.forward_backward_px);
    cv::parallel_for_(cv::Range(0, static_cast<int>(rows.size())), [&](const cv::Range& range) {
      for (int k = range.start; k < range.end; ++k) {
        FeatureTrack& track = tracks_[rows[k]];
        const Eigen::Vector2f before = track.warp.t;
        const bool consistent = found[k] && found_back[k] && cv::norm(back[k] - from[k]) <= limit;
        Settle(consistent, FromCv(to[k]) + current_.Origin(), &track);
        if (track.status == FeatureStatus::Tracked) motion_[rows[k]] = track.warp.t - before;
      }
    });
  }

  /// Decides one feature's position and state from Lucas–Kanade's answer.
  void Settle(bool consistent, const Eigen::Vector2f& flow, FeatureTrack* track) const {
    if (!current_.Inside(flow, 2)) {
      track->status = FeatureStatus::Occluded;
      return;
    }
    if (current_.InstrumentAt(flow)) {
      track->status = FeatureStatus::Occluded;
      return;
    }
    if (!options_.reanchor) {
      if (!consistent)
        track->status = FeatureStatus::Lost;
      else
        track->warp.t = flow;
      return;
    }
    AffineWarp warp = track->warp;
    warp.t = flow - current_.Origin();
    const Alignment seen = track->patch.Align(current_.Smooth(), current_.Excluded(), 6, &warp);
    const Eigen::Vector2f anchored = warp.t + current_.Origin();
    const float away = (anchored - flow).norm();
    track->correlation = seen.valid ? seen.correlation : 0;
    if (seen.valid && seen.correlation >= options_.accept_correlation &&
        away <= options_.reanchor_limit_px) {
      track->warp = warp;
      track->warp.t = anchored;
      track->alone = 0;
      return;
    }
    if (!consistent) {
      track->status = FeatureStatus::Lost;
      return;
    }
    const bool hidden = !seen.valid || seen.correlation < options_.hidden_correlation;
    if (hidden || ++track->alone > options_.patience_frames) {
      track->status = FeatureStatus::Occluded;
      return;
    }
    track->warp.t = flow;
  }

  void RefuseLoners() {
    for (const int row : neighbours_.Loners(motion_, Positions())) {
      tracks_[row].status = FeatureStatus::Lost;
      tracks_[row].warp.t -= motion_[row];
      motion_[row].setConstant(std::numeric_limits<float>::quiet_NaN());
    }
  }

  std::vector<Eigen::Vector2f> Positions() const {
    std::vector<Eigen::Vector2f> positions;
    for (const FeatureTrack& track : tracks_) positions.push_back(track.warp.t);
    return positions;
  }

  /// Carries features that are not seen along with their neighbours (or to where the model expects
  /// them) and takes them back when their reference appearance is seen there again.
  void Recover() {
    std::vector<int> rows;
    for (std::size_t i = 0; i < tracks_.size(); ++i)
      if (tracks_[i].status != FeatureStatus::Tracked && !tracks_[i].patch.Empty())
        rows.push_back(static_cast<int>(i));
    const std::vector<Eigen::Vector2f> positions = Positions();
    for (const int row : rows) {
      if (row < predicted_.rows() && predicted_.row(row).allFinite()) {
        tracks_[row].warp.t = predicted_.row(row).cast<float>();
      } else {
        tracks_[row].warp.t += neighbours_.Expected(row, motion_, positions);
      }
    }
    // A bounded number a frame, in turn: a burst of losses must not cost frames.
    constexpr int kAttempts = 24;
    const int tries = std::min<int>(kAttempts, static_cast<int>(rows.size()));
    std::vector<int> turn;
    for (int k = 0; k < tries; ++k) turn.push_back(rows[(next_try_ + k) % rows.size()]);
    next_try_ += tries;
    cv::parallel_for_(cv::Range(0, tries), [&](const cv::Range& range) {
      for (int k = range.start; k < range.end; ++k) FindAgain(&tracks_[turn[k]]);
    });
  }

  void FindAgain(FeatureTrack* track) const {
    if (!current_.Inside(track->warp.t, 2) || current_.InstrumentAt(track->warp.t)) {
      track->status = FeatureStatus::Occluded;
      return;
    }
    AffineWarp best;
    float best_correlation = 0.5F;
    for (int dy = -6; dy <= 6; dy += 2)
      for (int dx = -6; dx <= 6; dx += 2) {
        AffineWarp warp = track->warp;
        warp.t +=
            Eigen::Vector2f(static_cast<float>(dx), static_cast<float>(dy)) - current_.Origin();
        const Alignment seen = track->patch.Compare(current_.Smooth(), current_.Excluded(), warp);
        if (seen.valid && seen.correlation > best_correlation) {
          best_correlation = seen.correlation;
          best = warp;
        }
      }
    if (best_correlation <= 0.5F) return;
    const Alignment seen = track->patch.Align(current_.Smooth(), current_.Excluded(), 10, &best);
    const float wanted = 0.5F + 0.5F * static_cast<float>(options_.accept_correlation);
    if (!seen.valid || seen.correlation < wanted || seen.used < 0.7F) return;
    best.t += current_.Origin();
    if ((best.t - track->warp.t).norm() > 9) return;
    track->warp = best;
    track->alone = 0;
    track->correlation = seen.correlation;
    track->status = FeatureStatus::Tracked;
  }

  TrackerOptions options_;
  TrackerImages previous_, current_;
  std::vector<FeatureTrack> tracks_;
  std::vector<Eigen::Vector2f> motion_;  ///< of this frame; NaN where not tracked
  NeighbourMotion neighbours_;
  Pixels predicted_{0, 2};
  std::size_t next_try_ = 0;
};

}  // namespace

std::unique_ptr<VideoTracker> MakeFeatureTracker(const TrackerOptions& options) {
  return std::make_unique<LucasKanadeTracker>(options);
}

}  // namespace kerf
