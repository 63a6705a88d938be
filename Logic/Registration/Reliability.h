#pragma once

#include <string>

#include "Core/Camera.h"
#include "Registration/RegistrationState.h"

namespace kerf {

struct StepReport;

enum class GateState { Green, Amber, Off };
const char* ToString(GateState state);

/// How far one frame's registration is to be trusted, from what the frame itself shows. Each part
/// is a physical quantity; the score is the worst of them (docs/reference/tracking.md).
struct Reliability {
  GateState state = GateState::Off;
  double score = 0.0;          ///< 0..1, the smallest of the parts below
  std::string reason;          ///< in words; "ok" when green
  double tumour_u95_mm = 0.0;  ///< 95 % radius of the tumour's position; NaN without a tumour
  double inliers =
      0.0;  ///< tracked features that agree with the model, of those tracked at the start
  double coverage = 0.0;  ///< share of the initial features that have an agreeing one beside them
  double residual_px = 0.0;      ///< median reprojection error of tracked features
  double residual_mm = 0.0;      ///< the same at the model's depth
  double local_misfit_mm = 0.0;  ///< the same, mm, in the neighbourhood where it is largest: a cut
                                 ///< that was missed, a part that was lost
  double outline_off = 0.0;      ///< share of the seen outline that lies off the model's
};

/// @param initially_tracked number of features that took part in the first frame
/// @param step what the frame's step reported about the outline; may be null
Reliability AssessReliability(const RegistrationState& state, const CameraModel& camera,
                              Index initially_tracked, const StepReport* step = nullptr);

}  // namespace kerf
