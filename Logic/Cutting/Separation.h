#pragma once

#include "Cutting/CutPatch.h"
#include "Cutting/SurfaceIndex.h"

namespace kerf {

struct SeparationReport {
  std::vector<OpenedFace> faces;  ///< in numbers of the patch
  Index duplicated_vertices = 0;
  double area_mm2 = 0;       ///< one side
  bool same_pieces = false;  ///< the patch hangs together as it did before: no piece came off
  bool stuck = false;        ///< both sides are joined somewhere though S goes on there
  Index closed = 0;          ///< faces on S that stay closed
  std::vector<std::array<int, 2>> kept;  ///< on both sides of those that stay closed where S goes
                                         ///< on, since the boundary would touch itself
  int chips = 0;             ///< pieces of a few tetrahedra that S cuts off and that stay joined
  std::vector<int> pinched;  ///< vertices in which the boundary would touch itself if all opened
};

/// Opens the patch along its faces on S: vertices are duplicated by the components of their
/// tetrahedra that hang together through other faces, so that a crack front stays joined. Faces
/// whose opening would touch itself in a single vertex or edge, or split off a chip of a few
/// tetrahedra, stay closed.
SeparationReport OpenFacesOnS(const SurfaceIndex& surface, CutPatch* patch);

/// All faces that the patch remembers as opened, in pairs whose corners lie in the same places.
/// Where a later sheet has moved one side of them a face has no pair and is left out.
std::vector<OpenedFace> OpenedFaces(const CutPatch& patch);

}  // namespace kerf
