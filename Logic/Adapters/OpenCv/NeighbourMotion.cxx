#include "Adapters/OpenCv/NeighbourMotion.h"

#include <algorithm>

namespace kerf {
namespace {

constexpr int kNeighbours = 10;
/// Difference of motion that tissue may show between two frames: so many px, and so much per
/// distance.
constexpr float kTolerance_px = 0.8F, kStrain = 0.03F;
/// The same for places since birth, after the patches' deformation has been accounted for.
constexpr float kPlaceTolerance_px = 1.5F, kPlaceStrain = 0.12F;

/// Difference of the places of a and b that their births and deformations suggest.
Eigen::Vector2f Offset(const NeighbourView& a, const NeighbourView& b) {
  return 0.5F * (a.shape + b.shape) * (b.birth - a.birth);
}

/// Where `neighbour` expects one that is not seen: as far away as at birth, deformed as it is
/// itself.
Eigen::Vector2f SuggestedBy(const NeighbourView& neighbour, const NeighbourView& unseen) {
  return neighbour.now + neighbour.shape * (unseen.birth - neighbour.birth);
}

}  // namespace

void NeighbourMotion::Build(const std::vector<NeighbourView>& features) {
  neighbours_.assign(features.size(), {});
  std::vector<std::pair<float, int>> order;
  for (std::size_t i = 0; i < features.size(); ++i) {
    order.clear();
    for (std::size_t j = 0; j < features.size(); ++j)
      if (i != j && features[i].generation == features[j].generation)
        order.emplace_back((features[i].birth - features[j].birth).squaredNorm(),
                           static_cast<int>(j));
    const std::size_t count = std::min<std::size_t>(kNeighbours, order.size());
    std::partial_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(count),
                      order.end());
    for (std::size_t k = 0; k < count; ++k) neighbours_[i].push_back(order[k].second);
  }
}

std::vector<int> NeighbourMotion::Loners(const std::vector<Eigen::Vector2f>& motion,
                                         const std::vector<NeighbourView>& features) const {
  std::vector<int> loners;
  for (std::size_t i = 0; i < neighbours_.size(); ++i) {
    if (!motion[i].allFinite()) continue;
    int known = 0, agreeing = 0;
    for (const int j : neighbours_[i]) {
      if (!motion[j].allFinite()) continue;
      ++known;
      const float distance = (features[i].now - features[j].now).norm();
      if ((motion[i] - motion[j]).norm() <= kTolerance_px + kStrain * distance) ++agreeing;
    }
    if (known >= 3 && agreeing < 2) loners.push_back(static_cast<int>(i));
  }
  return loners;
}

bool NeighbourMotion::Misplaced(int row, const NeighbourView& feature,
                                const std::vector<NeighbourView>& features) const {
  int known = 0, agreeing = 0;
  for (const int j : neighbours_[row]) {
    if (!features[j].seen) continue;
    ++known;
    const float distance = (features[j].birth - feature.birth).norm();
    const float misfit = (features[j].now - feature.now - Offset(feature, features[j])).norm();
    if (misfit <= kPlaceTolerance_px + kPlaceStrain * distance) ++agreeing;
  }
  // Half of the neighbours may lie beyond a cut, some may be wrong themselves.
  return known >= 4 && 4 * agreeing < known;
}

bool NeighbourMotion::Expected(int row, const std::vector<NeighbourView>& features,
                               Eigen::Vector2f* place) const {
  // The median of what the nearest suggest: those beyond a cut are outvoted.
  constexpr std::size_t kAsked = 5;
  std::vector<float> u, v;
  for (const int j : neighbours_[row]) {
    if (!features[j].seen || u.size() == kAsked) continue;
    const Eigen::Vector2f suggested = SuggestedBy(features[j], features[row]);
    u.push_back(suggested.x());
    v.push_back(suggested.y());
  }
  if (u.size() < 3) return false;
  const auto median = [](std::vector<float>& values) {
    std::sort(values.begin(), values.end());
    const std::size_t middle = values.size() / 2;
    return values.size() % 2 ? values[middle] : 0.5F * (values[middle - 1] + values[middle]);
  };
  *place = {median(u), median(v)};
  return true;
}

bool NeighbourMotion::ExpectedBy(int nth, int row, const std::vector<NeighbourView>& features,
                                 AffineWarp* place) const {
  int seen = 0;
  for (const int j : neighbours_[row]) {
    if (!features[j].seen || seen++ < nth) continue;
    *place = {features[j].shape, SuggestedBy(features[j], features[row])};
    return true;
  }
  return false;
}

}  // namespace kerf
