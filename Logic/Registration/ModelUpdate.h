#pragma once

#include "Registration/Step.h"

namespace kerf {

/// Extrusion of the cut line to the separation surface S, along the camera direction or a given
/// vector ("Expansion to cut surface"): from above the organ's surface to `depth_mm` below it.
CutSurface ExtrudeCut(const CutPolyline& line, const CameraModel& camera,
                      const MethodOptions& options, double depth_mm);

/// Cuts model and inner structures along the S of `cut` and carries features, velocities and solver
/// over by provenance. A refused increment leaves the state as it was.
CutReport ApplyCut(const ModelCut& cut, const MethodOptions& options, Engine& engine,
                   RegistrationState* state);

}  // namespace kerf
