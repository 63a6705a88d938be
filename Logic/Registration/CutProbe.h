#pragma once

#include <optional>

#include "Registration/Step.h"

namespace kerf {

struct CutProbeOptions {
  int pause_frames = 3;             ///< between two probes; ends and direction take turns
  int longest_pause_frames = 6;     ///< each probe in vain doubles the pause, up to this
  double step_mm = 2.5;             ///< how much longer a cut is tried
  double step_deg = 8.0;            ///< how much its S is tried turned about the line
  double steepest_deg = 32.0;       ///< from the line of sight
  double unexplained_mm = 0.4;      ///< residual of the grips below which nothing is tried
  double hopeless_mm = 2.5;         ///< nor above
  double nonlinear_strain2 = 0.25;  ///< nor where the law is not believed
  double gain = 0.04;               ///< of the cost that another cut has to save
  int steps = 4;                    ///< of the fit, for either side of the comparison
};

/// A cut that lets the organ under its grips follow the tracks better.
struct BetterCut {
  int cut = 0;
  ModelCut instead;
  bool turned = false;  ///< S has another direction: the model has to be cut anew (CutAnew)
};

/// The residual of the grips tells a cut that is too short, or leads into the depth in a wrong
/// direction, from the right one (Registration/GripFit.h). Tries on copies: longer at each end that
/// lies inside the organ; or turned about its line either way (state.probing says
/// which). Cuts that a surgeon drew or decides about are left alone.
std::optional<BetterCut> ProbeCuts(const std::vector<char>& usable, const CameraModel& camera,
                                   const MethodOptions& options, const CutProbeOptions& probe,
                                   const TetCutter& cutter, const RegistrationState& state);

}  // namespace kerf
