#include "Adapters/OpenCv/FeatureRecognition.h"

#include <algorithm>

namespace kerf {

Settled FeatureRecognition::Settle(const TrackerImages& image, const Eigen::Vector2f& flow,
                                   FeatureTrack* track) const {
  if (!image.Inside(flow, 2) || image.InstrumentAt(flow)) {
    track->status = FeatureStatus::Occluded;
    return Settled::Hidden;
  }
  if (!options_.reanchor) return Settled::Doubtful;
  AffineWarp warp = track->warp;
  warp.t = flow - image.Origin();
  const Alignment seen = Align(image, *track, 6, &warp);
  const Eigen::Vector2f anchored = warp.t + image.Origin();
  track->correlation = seen.valid ? seen.correlation : 0;
  // Tissue does not change its shape at once; what seems to is something else.
  const Eigen::Matrix2f change = warp.A * track->warp.A.inverse() - Eigen::Matrix2f::Identity();
  if (seen.valid && seen.correlation >= AcceptFrom() && change.norm() < 0.2F &&
      (anchored - flow).norm() <= options_.reanchor_limit_px) {
    track->warp.A = warp.A;
    track->warp.t = anchored;
    track->alone = 0;
    return Settled::Recognized;
  }
  return Settled::Doubtful;
}

void FeatureRecognition::FollowAlone(bool consistent, const Eigen::Vector2f& flow,
                                     FeatureTrack* track) const {
  if (!consistent) {
    track->status = FeatureStatus::Lost;
    return;
  }
  if (options_.reanchor && (track->correlation < usual_correlation_ * options_.hidden_correlation ||
                            ++track->alone > options_.patience_frames)) {
    track->status = FeatureStatus::Occluded;
    return;
  }
  track->warp.t = flow;
}

Alignment FeatureRecognition::Align(const TrackerImages& image, const FeatureTrack& track,
                                    int iterations, AffineWarp* warp) const {
  // As far as the warped patch reaches, and a pixel for rounding.
  const float reach = warp->A.cwiseAbs().rowwise().sum().maxCoeff();
  const float radius = reach * static_cast<float>(options_.patch_half_px) + 1.0F;
  return track.patch.Align(image.Smooth(), image.ExcludedNear(warp->t, radius), iterations, warp);
}

std::optional<Sighting> FeatureRecognition::Find(const TrackerImages& image,
                                                 const FeatureTrack& track,
                                                 const AffineWarp& place) const {
  AffineWarp best;
  float best_correlation = 0.5F;
  for (int dy = -kReach_px; dy <= kReach_px; dy += 3)
    for (int dx = -kReach_px; dx <= kReach_px; dx += 3) {
      AffineWarp warp = place;
      warp.t += Eigen::Vector2f(static_cast<float>(dx), static_cast<float>(dy)) - image.Origin();
      const Alignment seen = Align(image, track, 0, &warp);
      if (seen.valid && seen.correlation > best_correlation) {
        best_correlation = seen.correlation;
        best = warp;
      }
    }
  if (best_correlation <= 0.5F) return {};
  const Alignment seen = Align(image, track, 10, &best);
  const float wanted = 0.5F * usual_correlation_ + 0.5F * AcceptFrom();
  if (!seen.valid || seen.correlation < wanted || seen.used < 0.7F) return {};
  best.t += image.Origin();
  if ((best.t - place.t).norm() > 1.5F * kReach_px) return {};
  return Sighting{best, seen.correlation};
}

void FeatureRecognition::Learn(std::vector<float> correlations) {
  correlations.erase(std::remove_if(correlations.begin(), correlations.end(),
                                    [](float correlation) { return !(correlation > 0.5F); }),
                     correlations.end());
  if (correlations.size() < 20) return;
  const auto middle = correlations.begin() + static_cast<std::ptrdiff_t>(correlations.size() / 2);
  std::nth_element(correlations.begin(), middle, correlations.end());
  usual_correlation_ = std::clamp(0.8F * usual_correlation_ + 0.2F * *middle, 0.8F, 1.0F);
}

}  // namespace kerf
