#pragma once

#include "Adapters/Itk/Field.h"

namespace kerf {

/// How steep the image is in each voxel, HU/mm.
ScalarField EdgeStrength(const ScalarField& image, Progress& progress);

/// Geodesic active contour (Caselles 1997; ITK's level set), the snake of the method's paper in
/// three dimensions: pulls a boundary that is nearly right onto the image's edges and smooths it.
/// No balloon force, so that it cannot leak.
/// @param edges EdgeStrength of the image
/// @param inside signed distance to the boundary, mm, positive inside, on the image's grid
/// @return the same after `iterations`
ScalarField SnapToEdges(const ScalarField& edges, const ScalarField& inside, int iterations,
                        Progress& progress);

/// Voxels within one spacing of the boundary join the organ where they are on its side of half
/// contrast, between what lies inside and outside along the normal: smoothing pulls convex
/// boundaries inwards by a part of a voxel. Where the neighbour has nearly the organ's brightness,
/// nothing is changed; nothing is taken away, so that fat in folds of the organ stays.
Mask AtHalfContrast(const ScalarField& image, const Mask& organ);

}  // namespace kerf
