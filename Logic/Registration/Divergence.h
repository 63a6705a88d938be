#pragma once

#include <optional>
#include <vector>

#include "Registration/NeighborGraph.h"

namespace kerf {

/// Divergence of neighbouring features, Eq. (11): μ_lm = δ¹_lm/δ⁰_lm · ‖d_m − d_l‖ with d = p^t −
/// p¹.
/// @param neighbors E pairs with rest distances, mm
/// @param current   N×3, P_F^t, patient LPS, mm
/// @param targets   N×3, P_F¹, same rows as `current` (checked)
/// @param usable    N flags; a pair with an unusable feature has μ = −1 and takes no part in the
/// mean
/// @return E values ≥ 0 (or −1), mm
Eigen::VectorXd Divergence(const NeighborGraph& neighbors, const Points& current,
                           const Points& targets, const std::vector<char>& usable);

/// Pairs with μ_lm > τ μ_∅ and μ_lm > floor, in descending order of μ.
struct Outliers {
  std::vector<Index> pairs;
  double mean_mm = 0.0;  ///< μ_∅
};
Outliers FindOutliers(const Eigen::VectorXd& divergence, double tau, double floor_mm);

/// Leaves the outliers whose d_l and d_m point in different directions (d_l · d_m < 0), as the
/// paper says of the two sides of a cut, which the uncut model holds back towards each other. Where
/// an elastic model lags behind a stretch, at the ends of a band, d falls off steeply but points
/// one way.
void KeepOpposed(const NeighborGraph& neighbors, const Points& current, const Points& targets,
                 Outliers* outliers);

/// The outliers that hang together by shared features, the most numerous such region. The paper's
/// outliers "lie in a region where a cut or tear is likely to occur", and a barycentre only means
/// something within one: a few pairs at each end of a stretched organ are no cut in its middle.
std::vector<Index> LargestRegion(const Outliers& outliers, const NeighborGraph& neighbors);

/// "As soon as the number of outliers exceeds a given threshold n" (in one region): barycentre of
/// the region's pairs' centres at rest, weighted with μ.
std::optional<Vec3> CutPoint(const Outliers& outliers, const Eigen::VectorXd& divergence,
                             const NeighborGraph& neighbors, const Points& rest, int n);

}  // namespace kerf
