#include "Adapters/OpenCv/LucasKanadeTracker.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

#include "Adapters/OpenCv/CvMats.h"
#include "Adapters/OpenCv/FeatureDetection.h"
#include "Adapters/OpenCv/FeatureRecognition.h"
#include "Adapters/OpenCv/Masks.h"
#include "Adapters/OpenCv/NeighbourMotion.h"
#include "Adapters/OpenCv/TrackerImages.h"
#include "Core/Errors.h"

namespace kerf {
namespace {

cv::Point2f ToCv(const Eigen::Vector2f& p) { return {p.x(), p.y()}; }
Eigen::Vector2f FromCv(const cv::Point2f& p) { return {p.x, p.y}; }

/// work(begin, end) over parts of [0, count), in the caller's arena: OpenCV's loops run in one of
/// their own, to which threads take a while to move. (Its own loop inside a part still does, for
/// one part at a time.)
template <class Work>
void ForParts(int count, const Work& work) {
  constexpr int kPart = 16;
  tbb::parallel_for(
      tbb::blocked_range<int>(0, count, kPart),
      [&](const tbb::blocked_range<int>& range) { work(range.begin(), range.end()); },
      tbb::simple_partitioner());
}

class LucasKanadeTracker : public VideoTracker {
 public:
  explicit LucasKanadeTracker(const TrackerOptions& options)
      : options_(options), recognition_(options) {
    if (options.window_px < 5 || options.levels < 0 || options.levels > 6 ||
        options.patch_half_px < 4 || options.patch_half_px > 40)
      throw UsageError("tracker: window, levels or patch size out of range");
    // An unknown name is refused now, not at the first frame.
    DetectInterestPoints(cv::Mat(64, 64, CV_8U, cv::Scalar(0)),
                         cv::Mat(64, 64, CV_8U, cv::Scalar(255)), options.detector);
  }

  FeatureSet Detect(const Frame& frame, const Image& organ_mask, int wanted) override {
    tracks_.clear();
    recognition_ = FeatureRecognition(options_);
    FeatureSet features;
    features.pixels.resize(0, 2);
    current_.Load(frame, MaskBox(frame, organ_mask), options_.window_px, options_.levels);
    Append(organ_mask, wanted, &features);
    return features;
  }

  void Adopt(const Frame& frame, const Image& organ_mask, FeatureSet* features) override {
    tracks_.assign(features->Size(), {});
    recognition_ = FeatureRecognition(options_);
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
    for (const FeatureTrack& track : tracks_)
      views.push_back({track.birth, track.warp.t, track.warp.A, track.generation,
                       track.status == FeatureStatus::Tracked});
    return views;
  }

  int Append(const Image& organ_mask, int wanted, FeatureSet* features) {
    const cv::Mat excluded = Excluded(organ_mask);
    ++generation_;
    std::vector<cv::Point2f> taken;
    for (const FeatureTrack& track : tracks_)
      if (!track.patch.Empty()) taken.push_back(ToCv(track.warp.t - current_.Origin()));
    const int first_id =
        features->id.empty() ? 0 : *std::max_element(features->id.begin(), features->id.end()) + 1;
    std::vector<FeatureTrack> started;
    for (const InterestPoint& point :
         StartingPoints(current_.Grey(), excluded, options_.detector, wanted, taken)) {
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

  /// Pyramidal Lucas–Kanade of some points from one image to another.
  void Flow(const TrackerImages& one, const TrackerImages& other,
            const std::vector<cv::Point2f>& from, std::vector<cv::Point2f>* to,
            std::vector<std::uint8_t>* found) const {
    const cv::Size window(options_.window_px, options_.window_px);
    const cv::TermCriteria until(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 20, 0.02);
    to->resize(from.size());
    found->resize(from.size());
    ForParts(static_cast<int>(from.size()), [&](int begin, int end) {
      const std::vector<cv::Point2f> part(from.begin() + begin, from.begin() + end);
      std::vector<cv::Point2f> part_to;
      std::vector<std::uint8_t> part_found;
      std::vector<float> ignored;
      cv::calcOpticalFlowPyrLK(one.Pyramid(), other.Pyramid(), part, part_to, part_found, ignored,
                               window, options_.levels, until, 0, 1e-4);
      std::copy(part_to.begin(), part_to.end(), to->begin() + begin);
      std::copy(part_found.begin(), part_found.end(), found->begin() + begin);
    });
  }

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
    std::vector<std::uint8_t> found;
    Flow(previous_, current_, from, &to, &found);
    std::vector<Settled> settled(rows.size());
    std::vector<int> all(rows.size());
    std::iota(all.begin(), all.end(), 0);
    ForParts(static_cast<int>(rows.size()), [&](int begin, int end) {
      for (int k = begin; k < end; ++k)
        settled[k] =
            recognition_.Settle(current_, FromCv(to[k]) + current_.Origin(), &tracks_[rows[k]]);
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
    Flow(current_, previous_, doubtful_to, &back, &found_back);
    const float limit = static_cast<float>(options_.forward_backward_px);
    for (std::size_t d = 0; d < doubtful.size(); ++d) {
      const int k = doubtful[d];
      const bool consistent = found[k] && found_back[d] && cv::norm(back[d] - from[k]) <= limit;
      recognition_.FollowAlone(consistent, FromCv(to[k]) + current_.Origin(), &tracks_[rows[k]]);
    }
    for (const int k : all)
      if (tracks_[rows[k]].status == FeatureStatus::Tracked)
        motion_[rows[k]] = tracks_[rows[k]].warp.t - FromCv(from[k]) - current_.Origin();
    std::vector<float> correlations;
    for (const int k : all)
      if (settled[k] != Settled::Hidden) correlations.push_back(tracks_[rows[k]].correlation);
    recognition_.Learn(std::move(correlations));
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
    tbb::parallel_for(0, tries, [&](int k) { FindAgain(turn[k], views); });
  }

  /// Where to look for a feature that is not seen: in turn where the model or the neighbours
  /// together expect it, and where each of the nearest does, if that is somewhere else. Beside an
  /// opening the neighbours disagree, and a model that is not cut there yet is wrong on both of its
  /// sides.
  AffineWarp PlaceToLook(int row, const std::vector<NeighbourView>& views) {
    FeatureTrack& track = tracks_[row];
    const int turn = track.searches++ % (1 + kNeighboursAsked);
    AffineWarp place = track.warp;
    AffineWarp other;
    if (turn > 0 && neighbours_.ExpectedBy(turn - 1, row, views, &other) &&
        (other.t - place.t).norm() > FeatureRecognition::kReach_px)
      place = other;
    return place;
  }

  void FindAgain(int row, const std::vector<NeighbourView>& views) {
    FeatureTrack* track = &tracks_[row];
    const AffineWarp place = PlaceToLook(row, views);
    const auto hidden = [&](const Eigen::Vector2f& at) {
      return !current_.Inside(at, 2) || current_.InstrumentAt(at);
    };
    if (hidden(track->warp.t)) track->status = FeatureStatus::Occluded;
    if (hidden(place.t)) return;
    const std::optional<Sighting> seen = recognition_.Find(current_, *track, place);
    if (!seen) return;
    NeighbourView view = views[row];
    view.now = seen->warp.t;
    view.shape = seen->warp.A;
    if (options_.neighbours && neighbours_.Misplaced(row, view, views)) return;
    track->warp = seen->warp;
    track->alone = 0;
    track->correlation = seen->correlation;
    track->status = FeatureStatus::Tracked;
  }

  static constexpr int kNeighboursAsked = 3;

  TrackerOptions options_;
  TrackerImages previous_, current_;
  FeatureRecognition recognition_;
  std::vector<FeatureTrack> tracks_;
  std::vector<Eigen::Vector2f> motion_;  ///< of this frame; NaN where not tracked
  NeighbourMotion neighbours_;
  Pixels predicted_{0, 2};
  std::size_t next_try_ = 0;
  int generation_ = 0;
};

}  // namespace

std::unique_ptr<VideoTracker> MakeFeatureTracker(const TrackerOptions& options) {
  return std::make_unique<LucasKanadeTracker>(options);
}

}  // namespace kerf
