#pragma once

#include "Cutting/CoreNear.h"
#include "Cutting/CutPatch.h"
#include "Cutting/RemeshingOptions.h"
#include "Cutting/SurfaceIndex.h"

namespace kerf {

/// Moves core vertices near S onto it. Boundary vertices slide on the boundary: the direction is
/// orthogonal to their area vector, which keeps the volume exactly.
/// @param near of the patch, its vertices on S marked; kept up to date
/// @return the number of moved vertices
Index SnapVertices(const SurfaceIndex& surface, const RemeshingOptions& options,
                   const CutPatch& before, CoreNear* near, CutPatch* patch);

}  // namespace kerf
