#include "Adapters/OpenCv/LucasKanadeTracker.h"

#include <algorithm>
#include <limits>
#include <numeric>
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
  int generation = 0;           ///< number of the detection that found it
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
    usual_correlation_ = 1.0F;
    FeatureSet features;
    features.pixels.resize(0, 2);
    current_.Load(frame, MaskBox(frame, organ_mask), options_.window_px, options_.levels);
    Append(organ_mask, wanted, &features);
    return features;
  }

  void Adopt(const Frame& frame, const Image& organ_mask, FeatureSet* features) override {
    tracks_.assign(features->Size(), {});
    usual_correlation_ = 1.0F;
    features->status.assign(features->Size(), FeatureStatus::Lost);
    cv::Rect box = PointBox(features->pixels);
    current_.Load(frame, box, options_.window_px, options_.levels);
    const cv::Mat excluded = Excluded(organ_mask);
    for (Index i = 0; i < features->Size(); ++i) {
      Start(features->pixels.row(i).cast<float>(), excluded, &tracks_[i]);
      features->status[i] = tracks_[i].status;
    }
    neighbours_.Build(Views());
  }

  int Replenish(const Image& organ_mask, int wanted, FeatureSet* features) override {
    CheckRows(*features);
    return Append(organ_mask, wanted, features);
  }

  std::vector<float> Correlations() const override {
    std::vector<float> correlations;
    for (const FeatureTrack& track : tracks_)
      correlations.push_back(track.status == FeatureStatus::Tracked ? track.correlation : 0.0F);
    return correlations;
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
    track->generation = generation_;
    track->warp.t = pixel;
    if (track->patch.Take(current_.Smooth(), excluded, pixel - current_.Origin(),
                          options_.patch_half_px))
      track->status = FeatureStatus::Tracked;
  }
  std::vector<NeighbourView> Views() const {
    std::vector<NeighbourView> views;
    for (const FeatureTrack& track : tracks_) views.push_back(ViewOfTrack(track));
    return views;
  }
  static NeighbourView ViewOfTrack(const FeatureTrack& track) {
    return {track.birth, track.warp.t, track.warp.A, track.generation,
            track.status == FeatureStatus::Tracked};
  }

  int Append(const Image& organ_mask, int wanted, FeatureSet* features) {
    const cv::Mat excluded = Excluded(organ_mask);
    ++generation_;
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
    // Too few to choose from would mean clusters: corners fill in, after the detector's own points.
    if (static_cast<int>(points.size()) < 3 * wanted && options_.detector != "gftt") {
      float weakest = 0;
      for (const InterestPoint& point : points) weakest = std::min(weakest, point.score);
      std::vector<InterestPoint> corners = DetectInterestPoints(current_.Grey(), allowed, "gftt");
      for (InterestPoint& corner : corners) {
        corner.score += weakest - 1e7F;
        points.push_back(corner);
      }
    }
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
    neighbours_.Build(Views());
    return static_cast<int>(started.size());
  }

  // ---- one frame
  // ---------------------------------------------------------------------------------------------------

  /// Lucas–Kanade there and back, then the reference patch, for every feature that was seen in the
  /// last frame.
  void Follow() {
    std::vector<int> rows;
    std::vector<cv::Point2f> from, to;
    for (std::size_t i = 0; i < tracks_.size(); ++i)
      if (tracks_[i].status == FeatureStatus::Tracked) {
        rows.push_back(static_cast<int>(i));
        from.push_back(ToCv(tracks_[i].warp.t - current_.Origin()));
      }
    motion_.assign(tracks_.size(),
                   Eigen::Vector2f::Constant(std::numeric_limits<float>::quiet_NaN()));
    if (rows.empty()) return;
    const cv::Size window(options_.window_px, options_.window_px);
    const cv::TermCriteria until(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 20, 0.02);
    std::vector<std::uint8_t> found;
    std::vector<float> ignored;
    cv::calcOpticalFlowPyrLK(previous_.Pyramid(), current_.Pyramid(), from, to, found, ignored,
                             window, options_.levels, until, 0, 1e-4);
    std::vector<Settled> settled(rows.size());
    const auto for_all = [&](const std::vector<int>& list, const auto& work) {
      cv::parallel_for_(cv::Range(0, static_cast<int>(list.size())), [&](const cv::Range& range) {
        for (int k = range.start; k < range.end; ++k) work(list[k]);
      });
    };
    std::vector<int> all(rows.size());
    std::iota(all.begin(), all.end(), 0);
    for_all(all, [&](int k) {
      settled[k] = Settle(FromCv(to[k]) + current_.Origin(), tracks_[rows[k]]);
    });

    // The way back is the check for those that do not look like their reference; recognition is the
    // stronger one.
    std::vector<int> doubtful;
    std::vector<cv::Point2f> doubtful_to, back;
    for (const int k : all)
      if (settled[k] == Settled::Doubtful) {
        doubtful.push_back(k);
        doubtful_to.push_back(to[k]);
      }
    std::vector<std::uint8_t> found_back;
    if (!doubtful.empty())
      cv::calcOpticalFlowPyrLK(current_.Pyramid(), previous_.Pyramid(), doubtful_to, back,
                               found_back, ignored, window, options_.levels, until, 0, 1e-4);
    const float limit = static_cast<float>(options_.forward_backward_px);
    for (std::size_t d = 0; d < doubtful.size(); ++d) {
      const int k = doubtful[d];
      const bool consistent = found[k] && found_back[d] && cv::norm(back[d] - from[k]) <= limit;
      FollowAlone(consistent, FromCv(to[k]) + current_.Origin(), &tracks_[rows[k]]);
    }
    for (const int k : all)
      if (tracks_[rows[k]].status == FeatureStatus::Tracked)
        motion_[rows[k]] = tracks_[rows[k]].warp.t - FromCv(from[k]) - current_.Origin();
    LearnUsualCorrelation(settled, rows);
  }

  enum class Settled { Recognized, Hidden, Doubtful };

  /// Decides one feature's position from Lucas–Kanade's answer and its reference.
  Settled Settle(const Eigen::Vector2f& flow, FeatureTrack& track) const {
    if (!current_.Inside(flow, 2) || current_.InstrumentAt(flow)) {
      track.status = FeatureStatus::Occluded;
      return Settled::Hidden;
    }
    if (!options_.reanchor) return Settled::Doubtful;
    AffineWarp warp = track.warp;
    warp.t = flow - current_.Origin();
    const Alignment seen = Align(track, 6, &warp);
    const Eigen::Vector2f anchored = warp.t + current_.Origin();
    track.correlation = seen.valid ? seen.correlation : 0;
    // Tissue does not change its shape at once; what seems to is something else.
    const Eigen::Matrix2f change = warp.A * track.warp.A.inverse() - Eigen::Matrix2f::Identity();
    if (seen.valid && seen.correlation >= AcceptFrom() && change.norm() < 0.2F &&
        (anchored - flow).norm() <= options_.reanchor_limit_px) {
      track.warp.A = warp.A;
      track.warp.t = anchored;
      track.alone = 0;
      return Settled::Recognized;
    }
    return Settled::Doubtful;
  }

  /// A feature that was not recognized lives on Lucas–Kanade for a few frames, if that agrees with
  /// itself.
  void FollowAlone(bool consistent, const Eigen::Vector2f& flow, FeatureTrack* track) const {
    if (!consistent) {
      track->status = FeatureStatus::Lost;
      return;
    }
    if (options_.reanchor &&
        (track->correlation < usual_correlation_ * options_.hidden_correlation ||
         ++track->alone > options_.patience_frames)) {
      track->status = FeatureStatus::Occluded;
      return;
    }
    track->warp.t = flow;
  }

  Alignment Align(const FeatureTrack& track, int iterations, AffineWarp* warp) const {
    const float radius = 2.0F * static_cast<float>(options_.patch_half_px);
    return track.patch.Align(current_.Smooth(), current_.ExcludedNear(warp->t, radius), iterations,
                             warp);
  }
  float AcceptFrom() const {
    return usual_correlation_ * static_cast<float>(options_.accept_correlation);
  }

  /// Noise, smoke and compression lower all correlations alike: what counts is how a feature
  /// compares with the others.
  void LearnUsualCorrelation(const std::vector<Settled>& settled, const std::vector<int>& rows) {
    std::vector<float> correlations;
    for (std::size_t k = 0; k < rows.size(); ++k)
      if (settled[k] != Settled::Hidden && tracks_[rows[k]].correlation > 0.5F)
        correlations.push_back(tracks_[rows[k]].correlation);
    if (correlations.size() < 20) return;
    const auto middle = correlations.begin() + static_cast<std::ptrdiff_t>(correlations.size() / 2);
    std::nth_element(correlations.begin(), middle, correlations.end());
    usual_correlation_ = std::clamp(0.8F * usual_correlation_ + 0.2F * *middle, 0.8F, 1.0F);
  }

  void RefuseLoners() {
    for (const int row : neighbours_.Loners(motion_, Views())) {
      tracks_[row].status = FeatureStatus::Lost;
      tracks_[row].warp.t -= motion_[row];
    }
    const std::vector<NeighbourView> views = Views();
    for (std::size_t i = 0; i < tracks_.size(); ++i)
      if (views[i].seen && neighbours_.Misplaced(static_cast<int>(i), views[i], views))
        tracks_[i].status = FeatureStatus::Lost;
  }

  /// Carries features that are not seen along with their neighbours (or to where the model expects
  /// them) and takes them back when their reference appearance is seen there again.
  void Recover() {
    std::vector<int> rows;
    for (std::size_t i = 0; i < tracks_.size(); ++i)
      if (tracks_[i].status != FeatureStatus::Tracked && !tracks_[i].patch.Empty())
        rows.push_back(static_cast<int>(i));
    if (rows.empty()) return;
    const std::vector<NeighbourView> views = Views();
    for (const int row : rows) {
      Eigen::Vector2f place;
      if (row < predicted_.rows() && predicted_.row(row).allFinite())
        tracks_[row].warp.t = predicted_.row(row).cast<float>();
      else if (neighbours_.Expected(row, views, &place))
        tracks_[row].warp.t = place;
    }
    // A bounded number a frame, in turn: a burst of losses must not cost frames.
    constexpr int kAttempts = 24;
    const int tries = std::min<int>(kAttempts, static_cast<int>(rows.size()));
    std::vector<int> turn;
    for (int k = 0; k < tries; ++k) turn.push_back(rows[(next_try_ + k) % rows.size()]);
    next_try_ += tries;
    cv::parallel_for_(cv::Range(0, tries), [&](const cv::Range& range) {
      for (int k = range.start; k < range.end; ++k) FindAgain(turn[k], views);
    });
  }

  void FindAgain(int row, const std::vector<NeighbourView>& views) {
    FeatureTrack* track = &tracks_[row];
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
        const Alignment seen = Align(*track, 0, &warp);
        if (seen.valid && seen.correlation > best_correlation) {
          best_correlation = seen.correlation;
          best = warp;
        }
      }
    if (best_correlation <= 0.5F) return;
    const Alignment seen = Align(*track, 10, &best);
    const float wanted = 0.5F * usual_correlation_ + 0.5F * AcceptFrom();
    if (!seen.valid || seen.correlation < wanted || seen.used < 0.7F) return;
    best.t += current_.Origin();
    if ((best.t - track->warp.t).norm() > 9) return;
    NeighbourView view = views[row];
    view.now = best.t;
    view.shape = best.A;
    if (options_.neighbours && neighbours_.Misplaced(row, view, views)) return;
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
  int generation_ = 0;
  float usual_correlation_ = 1.0F;  ///< running median over the features that are followed
};

}  // namespace

std::unique_ptr<VideoTracker> MakeFeatureTracker(const TrackerOptions& options) {
  return std::make_unique<LucasKanadeTracker>(options);
}

}  // namespace kerf
