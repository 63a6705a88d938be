#pragma once

#include "Adapters/Itk/Field.h"

namespace kerf {

/// Geodesic active contour (Caselles 1997; ITK's level set), the snake of the method's paper in
/// three dimensions: pulls a boundary that is nearly right onto the image's edges and smooths it.
/// No balloon force, so that it cannot leak.
/// @param inside signed distance to the boundary, mm, positive inside, on the image's grid
/// @return the same after `iterations`
ScalarField SnapToEdges(const ScalarField& image, const ScalarField& inside, int iterations,
                        Progress& progress);

}  // namespace kerf
