#pragma once

#include <string>
#include <vector>

#include "Core/Embedding.h"
#include "Core/SurfaceMesh.h"
#include "Core/TopologyChange.h"

namespace kerf {

/// An inner structure: rest surface and its embedding in the organ mesh.
struct Structure {
  std::string name;     ///< "internal", "tumour"
  SurfaceMesh rest;     ///< P_I⁰, C_I
  Embedding embedding;  ///< one row per rest point
};

enum class StructureCutMode {
  Split,           ///< triangles are split exactly along S
  DeleteTriangles  ///< Eq. (12): triangles that meet S are deleted
};

/// The structure after the organ was cut along `surface` (whole S so far, rest). Only where the
/// organ was really opened (`change.opened`) is the structure cut, so that both part along the same
/// faces; new rim points lie on S where S crosses the same edge, and hang on the tetrahedra of
/// their own side. Old points keep their rows.
/// @param change the organ's change; @param old_mesh the organ's mesh before it
Structure CutStructureSurface(const Structure& structure, const CutSurface& surface,
                              const TopologyChange& change, const TetMesh& old_mesh,
                              StructureCutMode mode);

/// Volume of each edge-connected piece of a surface, mm³, in the order of their first triangles;
/// open rims (of a cut tumour) are closed by a fan around their middle.
std::vector<double> PieceVolumes_mm3(const SurfaceMesh& surface);

}  // namespace kerf
