#pragma once

#include "Cutting/CutPatch.h"
#include "Cutting/RemeshingOptions.h"
#include "Cutting/SurfaceIndex.h"

namespace kerf {

/// Moves vertices around tetrahedra below the goal: vertices on S within S, boundary vertices on
/// the boundary.
void ImprovePatch(const SurfaceIndex& surface, const RemeshingOptions& options,
                  const CutPatch& before, CutPatch* patch);

}  // namespace kerf
