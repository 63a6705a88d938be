#pragma once

#include <vector>

#include "Mechanics/ElasticSolver.h"

namespace kerf {

/// One spring in the current state, Eq. (4): W = ½ k ρ(r²) with the constrained residual r² = dᵀQd,
/// d = p − target, Q = I − (1 − a) n nᵀ (isotropic: Q = I), ρ(r²) = r² or Geman–McClure r² c²/(c² +
/// r²). Gradient k w Q d at p; the matrix k w Q of iterated reweighting majorizes the curvature, w
/// = ρ'(r²) ∈ (0, 1].
struct SpringState {
  double energy_nJ = 0.0;
  double weight = 1.0;
  Vec3 gradient = Vec3::Zero();  ///< µN
  Mat3 matrix = Mat3::Zero();    ///< g/s²
};

/// @param p current position of the feature, mm
SpringState EvaluateSpring(const Springs& springs, Index spring, const Vec3& p);

/// @throws UsageError: row counts that differ, a tetrahedron that the mesh doesn't have, negative
/// or infinite stiffness, directions that are not unit vectors
void ValidateSprings(const Springs& springs, Index tet_count);
void ValidateFixations(const Fixations& fixations, Index vertex_count);

/// Springs sorted for lookup by vertex: which springs pull at a vertex, and with which barycentric
/// weight. Vertex v owns entries [begin[v], begin[v+1]), ordered by spring.
struct SpringsByVertex {
  std::vector<Index> begin, spring;
  std::vector<double> weight;
};
SpringsByVertex SortSpringsByVertex(const Embedding& at, const Tets& tets, Index vertex_count);

}  // namespace kerf
