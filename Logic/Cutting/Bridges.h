#pragma once

#include "Core/TopologyChange.h"

namespace kerf {

/// Does tissue still hang together across S, two mean edges or more from where S ends? Remeshing
/// may leave a few tetrahedra whose faces no side of a fold of S claims; one of them holds a cut
/// organ together like a thread.
/// @param mesh that was cut along `surface`
bool JoinedAcross(const TetMesh& mesh, const CutSurface& surface);

}  // namespace kerf
