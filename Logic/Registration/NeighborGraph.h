#pragma once

#include <array>
#include <vector>

#include "Core/Types.h"

namespace kerf {

/// Neighbourhood of features, C_F: pairs (l, m), l < m, with their distance at rest.
struct NeighborGraph {
  std::vector<std::array<Index, 2>> pairs;
  Eigen::VectorXd rest_distance_mm;  ///< δ⁰_lm, one per pair

  Index Size() const { return static_cast<Index>(pairs.size()); }
};

/// C_F⁰ = {(l, m) | δ⁰_lm < radius}. @param rest N×3, mm. Coinciding features (< 0.1 mm) are no
/// neighbours.
NeighborGraph BuildNeighborGraph(const Points& rest, double radius_mm);

/// The pairs whose connection at rest does not cross the sphere around `center` ("Insertion of cut
/// points").
NeighborGraph RemoveCrossing(const NeighborGraph& graph, const Points& rest, const Vec3& center,
                             double radius_mm);

}  // namespace kerf
