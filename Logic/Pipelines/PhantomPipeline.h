#pragma once

#include <string>

#include "Core/Progress.h"
#include "Phantom/PhantomScenario.h"

namespace kerf {

struct PhantomRequest {
  PhantomScenario scenario = PhantomScenario::KidneyCut;
  std::string output;      ///< study folder to be made; an older study there is replaced
  std::uint32_t seed = 1;  ///< varies noise and textures
};

struct PhantomResult {
  int frames = 0;
  double final_opening_mm = 0.0;  ///< of the widest cut at its entry; 0 without a cut
};

/// Writes a synthetic patient as a study folder with truth (docs/reference/phantom.md). The folder
/// appears when it is complete; the same scenario and seed give the same bits.
/// @throws UsageError when `output` holds something that is not a study; InputError when it cannot
/// be written; Cancelled
PhantomResult MakePhantom(const PhantomRequest& request, Progress& progress);

}  // namespace kerf
