#pragma once

#include "Core/Camera.h"
#include "Registration/Step.h"

namespace kerf {

/// What a surgeon's decisions about cuts need from the engine. Offline none of it is used.

/// Puts mesh and structures back as they were in `before`; what is tracked, detected and decided
/// since stays, and the material stays where it is now. Solver and cutter forget what they kept of
/// the cut model.
/// @param before a copy of the state before a cut
void RestoreModel(const RegistrationState& before, const MethodOptions& options, Engine& engine,
                  RegistrationState* state);

/// Pairs of features that `line` (rest surface, mm) parts do not speak for a cut any more, unless
/// they part clearly farther than now (`WithoutRefused`): what opens on and on is proposed again.
void RefuseEvidence(const Points& line, RegistrationState* state);

/// A stroke over the image as a line on the rest surface: each pixel's ray is cut with the organ as
/// it is now, and taken back to rest. Pixels beside the organ continue at the depth of the nearest
/// one on it, so that a stroke over the rim goes over the rim.
/// @param pixels N×2 raw distorted px, in order; @return M×3, LPS, mm; no rows where fewer than two
/// pixels meet the organ
Points RestLineOfStroke(const Pixels& pixels, const CameraModel& camera,
                        const RegistrationState& state);

/// A cut as a surgeon gives it: line at rest, direction and depth of S. An end that stops less than
/// one element (5 mm at most) before the organ's rim goes over it: nobody leaves a strip that thin.
ModelCut MakeDrawnCut(const Points& line, const Vec3& direction, double depth_mm,
                      const RegistrationState& state);

}  // namespace kerf
