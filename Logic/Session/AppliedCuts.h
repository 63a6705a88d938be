#pragma once

#include <vector>

#include "CaseIO/ResultsFiles.h"
#include "Registration/RegistrationState.h"

namespace kerf {

/// Neither rejected (it has no S any more) nor a mere proposal.
bool IsApplied(const ModelCut& cut);

/// The cuts of the model that are applied.
/// @param uncut the organ's rest surface before any cut: their lines lie on it
std::vector<CutRecord> AppliedCuts(const RegistrationState& state, const SurfaceTree& uncut);

}  // namespace kerf
