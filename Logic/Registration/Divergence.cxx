#include "Registration/Divergence.h"

#include <algorithm>
#include <map>
#include <stdexcept>

namespace kerf {

Eigen::VectorXd Divergence(const NeighborGraph& neighbors, const Points& current,
                           const Points& targets, const std::vector<char>& usable) {
  if (current.rows() != targets.rows() || usable.size() != static_cast<std::size_t>(current.rows()))
    throw std::invalid_argument("Divergence: current, targets and usable differ in length");
  Eigen::VectorXd mu(neighbors.Size());
  for (Index e = 0; e < neighbors.Size(); ++e) {
    const auto [l, m] = neighbors.pairs[e];
    if (!usable[l] || !usable[m]) {
      mu[e] = -1.0;
      continue;
    }
    const double target_distance = (targets.row(l) - targets.row(m)).norm();
    const auto divergence = (current.row(m) - targets.row(m)) - (current.row(l) - targets.row(l));
    mu[e] = target_distance / neighbors.rest_distance_mm[e] * divergence.norm();
  }
  return mu;
}

Outliers FindOutliers(const Eigen::VectorXd& divergence, double tau, double floor_mm) {
  Outliers out;
  double sum = 0.0;
  Index count = 0;
  for (double mu : divergence)
    if (mu >= 0.0) {
      sum += mu;
      ++count;
    }
  if (count == 0) return out;
  out.mean_mm = sum / count;
  const double threshold = std::max(tau * out.mean_mm, floor_mm);
  for (Index e = 0; e < divergence.size(); ++e)
    if (divergence[e] > threshold) out.pairs.push_back(e);
  std::stable_sort(out.pairs.begin(), out.pairs.end(),
                   [&](Index a, Index b) { return divergence[a] > divergence[b]; });
  return out;
}

void KeepOpposed(const NeighborGraph& neighbors, const Points& current, const Points& targets,
                 Outliers* outliers) {
  const auto alike = [&](Index e) {
    const auto [l, m] = neighbors.pairs[e];
    return (current.row(l) - targets.row(l)).dot(current.row(m) - targets.row(m)) >= 0.0;
  };
  auto& pairs = outliers->pairs;
  pairs.erase(std::remove_if(pairs.begin(), pairs.end(), alike), pairs.end());
}

std::vector<Index> LargestRegion(const Outliers& outliers, const NeighborGraph& neighbors) {
  // Regions by shared features: union–find over the features of the outliers.
  std::map<Index, Index> root;
  const auto find = [&](Index feature) {
    Index at = root.emplace(feature, feature).first->second;
    while (root[at] != at) at = root[at];
    root[feature] = at;
    return at;
  };
  for (Index e : outliers.pairs) {
    const Index a = find(neighbors.pairs[e][0]), b = find(neighbors.pairs[e][1]);
    root[std::max(a, b)] = std::min(a, b);
  }
  std::map<Index, Index> size;
  for (Index e : outliers.pairs) ++size[find(neighbors.pairs[e][0])];
  Index largest = -1;
  for (Index e : outliers.pairs) {  // of equals the one with the greatest divergence
    const Index region = find(neighbors.pairs[e][0]);
    if (largest < 0 || size[region] > size[largest]) largest = region;
  }
  std::vector<Index> region;
  for (Index e : outliers.pairs)
    if (find(neighbors.pairs[e][0]) == largest) region.push_back(e);
  return region;
}

std::optional<Vec3> CutPoint(const Outliers& outliers, const Eigen::VectorXd& divergence,
                             const NeighborGraph& neighbors, const Points& rest, int n) {
  const std::vector<Index> region = LargestRegion(outliers, neighbors);
  if (static_cast<int>(region.size()) <= n) return std::nullopt;
  Vec3 sum = Vec3::Zero();
  double weight = 0.0;
  for (Index e : region) {
    const auto [l, m] = neighbors.pairs[e];
    sum += divergence[e] * 0.5 * (rest.row(l) + rest.row(m)).transpose();
    weight += divergence[e];
  }
  return Vec3(sum / weight);
}

}  // namespace kerf
