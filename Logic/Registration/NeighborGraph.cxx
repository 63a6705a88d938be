#include "Registration/NeighborGraph.h"

#include <algorithm>

namespace kerf {
namespace {

double SegmentDistance(const Vec3& a, const Vec3& b, const Vec3& p) {
  const Vec3 ab = b - a;
  const double t = std::clamp(ab.dot(p - a) / std::max(ab.squaredNorm(), 1e-12), 0.0, 1.0);
  return (a + t * ab - p).norm();
}

}  // namespace

NeighborGraph BuildNeighborGraph(const Points& rest, double radius_mm) {
  NeighborGraph graph;
  std::vector<double> distances;
  for (Index l = 0; l < rest.rows(); ++l)
    for (Index m = l + 1; m < rest.rows(); ++m) {
      const double distance = (rest.row(l) - rest.row(m)).norm();
      if (distance >= radius_mm || distance < 0.1) continue;
      graph.pairs.push_back({l, m});
      distances.push_back(distance);
    }
  graph.rest_distance_mm = Eigen::Map<Eigen::VectorXd>(distances.data(), distances.size());
  return graph;
}

NeighborGraph RemoveCrossing(const NeighborGraph& graph, const Points& rest, const Vec3& center,
                             double radius_mm) {
  NeighborGraph kept;
  std::vector<double> distances;
  for (Index e = 0; e < graph.Size(); ++e) {
    const auto [l, m] = graph.pairs[e];
    if (SegmentDistance(rest.row(l).transpose(), rest.row(m).transpose(), center) <= radius_mm)
      continue;
    kept.pairs.push_back(graph.pairs[e]);
    distances.push_back(graph.rest_distance_mm[e]);
  }
  kept.rest_distance_mm = Eigen::Map<Eigen::VectorXd>(distances.data(), distances.size());
  return kept;
}

}  // namespace kerf
