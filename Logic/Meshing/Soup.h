#pragma once

// Private to the CGAL files of Meshing.
#include <array>
#include <vector>

#include "Core/SurfaceMesh.h"

namespace kerf {

template <typename Point>
void ToSoup(const SurfaceMesh& surface, std::vector<Point>* points,
            std::vector<std::array<std::size_t, 3>>* triangles) {
  points->resize(surface.points.rows());
  for (Index i = 0; i < surface.points.rows(); ++i)
    (*points)[i] = Point(surface.points(i, 0), surface.points(i, 1), surface.points(i, 2));
  triangles->resize(surface.triangles.rows());
  for (Index t = 0; t < surface.triangles.rows(); ++t)
    for (int k = 0; k < 3; ++k)
      (*triangles)[t][k] = static_cast<std::size_t>(surface.triangles(t, k));
}

}  // namespace kerf
