#pragma once

#include "Core/TetMesh.h"

namespace kerf {

struct DihedralOptions {
  double wanted_deg = 8.0;
  double boundary_shift_mm = 0.0;   ///< how far a vertex of the outer boundary may move in all
  double interface_shift_mm = 0.0;  ///< the same between regions; vertices within a region are free
};

/// Moves vertices of tetrahedra with a smaller dihedral angle than wanted, each to where the
/// smallest angle around it grows, until all reach it or none can be bettered. What Mesh_3's
/// perturbation leaves lies where region boundaries meet the surface: it must not move those
/// vertices, a fraction of a millimetre suffices. Connectivity stays; no tetrahedron gets worse
/// than the worst around its vertex was. Deterministic.
/// @return smallest dihedral angle, degrees
double ImproveDihedral(const DihedralOptions& options, TetMesh* mesh);

}  // namespace kerf
