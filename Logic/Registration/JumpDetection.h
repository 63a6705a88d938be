#pragma once

#include <vector>

#include "Registration/Step.h"

namespace kerf {

/// Kerf's cut detection for one frame: displacement jumps between neighbouring features → evidence
/// over time → lines through the gaps → cuts that begin or grow. Several cuts; none of the paper's
/// thresholds.
/// @param lateral N×2 current feature positions in camera x, y at their rest depth, mm
/// @return events of cuts whose committed line grew; `state->cuts` holds the new lines and S
std::vector<CutEvent> DetectCutsByJumps(const Pixels& lateral, const std::vector<char>& usable,
                                        const CameraModel& camera, const MethodOptions& options,
                                        RegistrationState* state);

}  // namespace kerf
