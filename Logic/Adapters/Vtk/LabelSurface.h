#pragma once

#include "Core/SurfaceMesh.h"
#include "Core/Volume.h"
#include "Meshing/LabelField.h"

namespace kerf {

/// Boundary of a label field (Meshing/LabelField.h) as a closed manifold surface, outwards, LPS mm.
/// Below voxel size: the field's level set, not the voxels' stairs. Voxels coarser or finer than
/// needed are resampled, so that the surface has at most about `max_points` points.
/// @throws InputError naming `source` when the field is empty
SurfaceMesh SurfaceOfField(const LabelField& field, const std::string& source,
                           Index max_points = 12000);

}  // namespace kerf
