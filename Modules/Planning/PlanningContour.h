#pragma once

#include <functional>

#include "Core/Progress.h"
#include "Session/PlanningTools.h"

namespace kerf {

/// Active contour on one label, in steps that can be watched: the boundary moves onto the CT's
/// edges (the geodesic contour of the presets). Other labels keep their voxels.
/// @param step called on the working thread with the voxels after every few iterations
/// @return the voxels at the end. Cancelling throws; what `step` was given last is then the result
LabelVoxels EvolveContour(const Volume& ct, const LabelMap& labels, int label,
                          const std::function<void(const LabelVoxels&)>& step, Progress& progress);

}  // namespace kerf
