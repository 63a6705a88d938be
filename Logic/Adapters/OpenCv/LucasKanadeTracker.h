#pragma once

#include <memory>
#include <string>
#include <vector>

#include "Core/Features.h"

namespace kerf {

/// Options of the tracker. The defaults serve every study; docs/reference/tracking.md says what was
/// measured.
struct TrackerOptions {
  std::string detector = "fast-hessian";  ///< fast-hessian, gftt, akaze, orb, brisk, sift
  int window_px = 15;                     ///< side of Lucas–Kanade's window
  int levels = 3;                         ///< pyramid levels above the image
  double forward_backward_px = 0.8;       ///< largest distance after tracking there and back
  bool reanchor = true;    ///< align with the reference patch in every frame: no drift
  int patch_half_px = 10;  ///< the reference patch is 2·half+1 px wide
  double accept_correlation =
      0.92;  ///< the reference is believed from this share of the usual correlation on
  double hidden_correlation = 0.75;  ///< below this share something else is seen there
  double reanchor_limit_px = 2.0;  ///< farther from Lucas–Kanade's answer, one of the two is wrong
  int patience_frames = 4;         ///< how long a feature lives on Lucas–Kanade alone
  bool neighbours = true;          ///< refuse motion that no neighbour shares
  bool recover = true;  ///< look for lost features where neighbours or the model expect them
};

/// Tracks over a video, with what the plain interface does not offer.
class VideoTracker : public FeatureTracker {
 public:
  /// Takes over features that were found elsewhere (another detector, a test). @param organ_mask as
  /// in Detect; an image of size 0 means all of the frame. Features whose patch cannot be used come
  /// back `Lost`.
  virtual void Adopt(const Frame& frame, const Image& organ_mask, FeatureSet* features) = 0;
  /// Adds rows for features on tissue that has none (surface that came into view), in the frame of
  /// the last Track.
  /// @return how many rows were appended; ids go on from the largest
  virtual int Replenish(const Image& organ_mask, int wanted, FeatureSet* features) = 0;
  /// How much each feature looks like its reference now: normalized cross-correlation, 0 where it
  /// was not compared.
  virtual std::vector<float> Correlations() const = 0;
};

/// Fast-Hessian (or another detector's) features, pyramidal Lucas–Kanade from frame to frame with a
/// forward–backward check, each position then aligned affinely with the feature's appearance in its
/// first frame, so that errors do not add up. Results do not depend on the number of threads.
/// @throws UsageError on an unknown detector or an impossible option
std::unique_ptr<VideoTracker> MakeFeatureTracker(const TrackerOptions& options = {});

}  // namespace kerf
