#pragma once

#include <array>
#include <vector>

#include "Core/Types.h"

namespace kerf {

/// Delaunay triangulation of points in the plane. Deterministic; coinciding points are left out
/// (the first one stays).
/// @param points N×2, any unit; @return triangles as counter-clockwise indices, sorted; empty when
/// all are collinear
std::vector<std::array<Index, 3>> DelaunayTriangles(const Pixels& points);

}  // namespace kerf
