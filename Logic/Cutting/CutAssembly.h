#pragma once

#include <vector>

#include "Core/TopologyChange.h"
#include "Cutting/CutPatch.h"

namespace kerf {

/// Nothing changed, in memory for a mesh of this size.
TopologyChange Unchanged(const TetMesh& mesh, Index vertices, Index tets);

/// Puts the patch back into the mesh. Unchanged tetrahedra and all old vertices keep their numbers.
/// @param before the patch before the cut
/// @param opened in numbers of the patch
TopologyChange Assemble(const TetMesh& mesh, const CutPatch& before, const CutPatch& patch,
                        const std::vector<OpenedFace>& opened);

/// Volumes of the mesh's pieces. Pieces share no vertices: the boundary is 2-manifold.
std::vector<double> ComponentVolumes_mm3(const TetMesh& mesh);

}  // namespace kerf
