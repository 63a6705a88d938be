#pragma once

#include "Core/Embedding.h"
#include "Core/TetMesh.h"

namespace kerf {

struct EmbeddingReport {
  Index inside = 0;
  Index outside = 0;               ///< bound to the nearest tetrahedron by extrapolation
  double largest_distance_mm = 0;  ///< of an outside point to the mesh
};

/// Barycentric embedding of `points` (rest, LPS mm) in `mesh` at rest. Exact for affine maps.
/// @throws std::invalid_argument when the mesh has no tetrahedra
Embedding EmbedPoints(const TetMesh& mesh, const Points& points, EmbeddingReport* report = nullptr);

}  // namespace kerf
