#pragma once
// Private to Pipelines: a label map that moved and was cut with the organ.

#include <optional>

#include "Core/Progress.h"
#include "Core/TetMesh.h"
#include "Core/Volume.h"

namespace kerf {

/// Labels as deformed: every voxel inside a tetrahedron of `positions` gets the label that
/// `planned` has at its rest position (the tetrahedron's region where that is background or there
/// is no planned map); the rest is background.
/// @param planned label map at rest, gives the grid (extended to hold the moved organ); none = 1 mm
/// voxels around
LabelMap DeformedLabels(const TetMesh& mesh, const Points& positions,
                        const std::optional<LabelMap>& planned, Progress& progress);

}  // namespace kerf
