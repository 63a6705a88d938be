#pragma once

#include "Registration/Step.h"

namespace kerf {

/// Extrusion of the cut line to the separation surface S ("Expansion to cut surface"): from in
/// front of the organ's surface to `depth_mm` below it. @param direction unit, into the tissue
CutSurface ExtrudeCut(const CutPolyline& line, const Vec3& direction, double depth_mm);

/// Cuts model and inner structures along the S of `cut` and carries features, velocities and solver
/// over by provenance. A refused increment leaves the state as it was.
CutReport ApplyCut(const ModelCut& cut, const MethodOptions& options, Engine& engine,
                   RegistrationState* state);

}  // namespace kerf
