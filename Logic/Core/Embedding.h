#pragma once

#include <vector>

#include "Core/TetMesh.h"
#include "Core/Types.h"

namespace kerf {

/// Barycentric embedding of points in a tetra mesh: p = Σ_k w_k · P_V[tet_k] (features P_F and
/// structures P_I alike). Points slightly outside are bound to the nearest tetrahedron by
/// extrapolating weights (negative weights).
struct Embedding {
  std::vector<Index> tet;  ///< N tetrahedra
  Weights4 weights;        ///< N×4, rows sum to 1

  Index Size() const { return static_cast<Index>(tet.size()); }
  /// Current positions of the embedded points. @param positions vertex positions; @return N×3, mm
  Points Positions(const Points& positions, const Tets& tets) const;
  void Positions(const Points& positions, const Tets& tets, Points* out) const;
};

/// Barycentric weights of p in the tetrahedron with these corners (any p; sums to 1).
Vec4 BarycentricWeights(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);

}  // namespace kerf
