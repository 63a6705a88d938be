#pragma once

#include <functional>

#include "Core/Progress.h"
#include "Session/PlanningTools.h"

namespace kerf {

/// Active contour on one label, in steps that can be watched: the boundary moves onto the CT's
/// edges (the geodesic contour of the presets). Other labels keep their voxels.
/// @param voxels the map with the contour where it is now: at its end on return, and after a cancel
///   (throws) as far as it had come; empty before the first step
/// @param step called on the working thread after every few iterations, when `voxels` has moved
void EvolveContour(const Volume& ct, const LabelMap& labels, int label, LabelVoxels* voxels,
                   const std::function<void()>& step, Progress& progress);

}  // namespace kerf
