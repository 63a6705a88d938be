#include "Adapters/OpenCv/NeighbourMotion.h"

#include <algorithm>

namespace kerf {
namespace {

constexpr int kNeighbours = 10;
constexpr float kTolerance_px = 0.8F;
/// Difference of motion per distance that tissue may show between two frames.
constexpr float kStrain = 0.03F;

}  // namespace

void NeighbourMotion::Build(const std::vector<Eigen::Vector2f>& births) {
  neighbours_.assign(births.size(), {});
  std::vector<std::pair<float, int>> order(births.size());
  for (std::size_t i = 0; i < births.size(); ++i) {
    for (std::size_t j = 0; j < births.size(); ++j)
      order[j] = {i == j ? -1.0F : (births[i] - births[j]).squaredNorm(), static_cast<int>(j)};
    const std::size_t count = std::min<std::size_t>(kNeighbours + 1, births.size());
    std::partial_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(count),
                      order.end());
    for (std::size_t k = 1; k < count; ++k) neighbours_[i].push_back(order[k].second);
  }
}

std::vector<int> NeighbourMotion::Loners(const std::vector<Eigen::Vector2f>& motion,
                                         const std::vector<Eigen::Vector2f>& positions) const {
  std::vector<int> loners;
  for (std::size_t i = 0; i < neighbours_.size(); ++i) {
    if (!motion[i].allFinite()) continue;
    int known = 0, agreeing = 0;
    for (const int j : neighbours_[i]) {
      if (!motion[j].allFinite()) continue;
      ++known;
      const float distance = (positions[i] - positions[j]).norm();
      if ((motion[i] - motion[j]).norm() <= kTolerance_px + kStrain * distance) ++agreeing;
    }
    if (known >= 3 && agreeing < 2) loners.push_back(static_cast<int>(i));
  }
  return loners;
}

Eigen::Vector2f NeighbourMotion::Expected(int row, const std::vector<Eigen::Vector2f>& motion,
                                          const std::vector<Eigen::Vector2f>& positions) const {
  Eigen::Vector2f sum = Eigen::Vector2f::Zero();
  float weights = 0;
  for (const int j : neighbours_[row]) {
    if (!motion[j].allFinite()) continue;
    const float weight = 1.0F / (25.0F + (positions[row] - positions[j]).squaredNorm());
    sum += weight * motion[j];
    weights += weight;
  }
  if (weights == 0) return Eigen::Vector2f::Zero();
  return sum / weights;
}

}  // namespace kerf
