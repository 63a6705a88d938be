#pragma once

#include <vector>

#include "CaseIO/ResultsFiles.h"
#include "Registration/RegistrationState.h"

namespace kerf {

/// Cuts of the model that are neither rejected nor mere proposals.
/// @param uncut the organ's rest surface before any cut: their lines lie on it
std::vector<CutRecord> AppliedCuts(const RegistrationState& state, const SurfaceTree& uncut);

}  // namespace kerf
