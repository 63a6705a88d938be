#pragma once

#include <optional>

#include "Registration/Step.h"

namespace kerf {

struct CutProbeOptions {
  int every_frames = 6;
  double step_mm = 2.5;         ///< how much longer a cut is tried
  double unexplained_mm = 0.4;  ///< residual of the grips below which nothing is tried
  double gain = 0.04;           ///< of the cost that a longer cut has to save
  int steps = 4;                ///< of the fit, for either side of the comparison
};

/// Does the organ under its grips follow the tracks better with a longer cut? The residual of the
/// grips tells a cut that is too short from the right one (Registration/GripFit.h). Tries each end
/// that lies inside the organ, on copies.
/// @return the best cut that is enough better, to be put in the place of state.cuts[cut]
struct LongerCut {
  int cut = 0;
  ModelCut grown;
};
std::optional<LongerCut> ProbeCutEnds(const std::vector<char>& usable, const CameraModel& camera,
                                      const MethodOptions& options, const CutProbeOptions& probe,
                                      const TetCutter& cutter, const RegistrationState& state);

}  // namespace kerf
