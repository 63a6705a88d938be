#pragma once

#include <optional>
#include <vector>

#include "Adapters/OpenCv/LucasKanadeTracker.h"
#include "Adapters/OpenCv/PatchAligner.h"
#include "Adapters/OpenCv/TrackerImages.h"

/// Inside this component only: whether what is seen at a place is the feature that was taken there.
namespace kerf {

/// What the tracker remembers of one feature.
struct FeatureTrack {
  Patch patch;
  AffineWarp warp;              ///< where it is (warp.t, full image px) and how it is deformed
  Eigen::Vector2f birth{0, 0};  ///< where it was taken
  int generation = 0;           ///< number of the detection that found it
  FeatureStatus status = FeatureStatus::Lost;
  int alone = 0;     ///< frames since the reference patch was last recognized
  int searches = 0;  ///< how often it has been looked for
  float correlation = 1;
};

/// Hidden: it cannot be seen there; doubtful: it does not look like its reference.
enum class Settled { Recognized, Hidden, Doubtful };

struct Sighting {
  AffineWarp warp;  ///< full image px
  float correlation = 0;
};

/// Compares features with their reference patches. Noise, smoke and compression lower all
/// correlations alike: what counts is how a feature compares with the others.
class FeatureRecognition {
 public:
  explicit FeatureRecognition(const TrackerOptions& options) : options_(options) {}

  /// Decides one feature's position from Lucas–Kanade's answer and its reference.
  /// @param flow full image px
  Settled Settle(const TrackerImages& image, const Eigen::Vector2f& flow,
                 FeatureTrack* track) const;
  /// A feature that was not recognized lives on Lucas–Kanade for a few frames, if that agrees with
  /// itself.
  void FollowAlone(bool consistent, const Eigen::Vector2f& flow, FeatureTrack* track) const;
  /// How far around a place Find looks to either side.
  static constexpr int kReach_px = 6;
  /// Looks for a feature around a place where it may be: a coarse search, then alignment. Stricter
  /// than Settle.
  std::optional<Sighting> Find(const TrackerImages& image, const FeatureTrack& track,
                               const AffineWarp& place) const;
  /// The usual correlation follows the median of a frame's. @param correlations of the features
  /// that could be seen
  void Learn(std::vector<float> correlations);

 private:
  Alignment Align(const TrackerImages& image, const FeatureTrack& track, int iterations,
                  AffineWarp* warp) const;
  float AcceptFrom() const {
    return usual_correlation_ * static_cast<float>(options_.accept_correlation);
  }

  TrackerOptions options_;
  float usual_correlation_ = 1.0F;  ///< running median over the features that are followed
};

}  // namespace kerf
