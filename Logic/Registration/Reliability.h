#pragma once

#include <string>

#include "Core/Camera.h"
#include "Registration/RegistrationState.h"

namespace kerf {

enum class GateState { Green, Amber, Off };
const char* ToString(GateState state);

/// How far one frame's registration is to be trusted, from what the frame itself shows.
struct Reliability {
  GateState state = GateState::Off;
  double score = 0.0;          ///< 0..1, the smallest of the parts below
  std::string reason;          ///< in words; "ok" when green
  double tumour_u95_mm = 0.0;  ///< 95 % radius of the tumour's position; NaN without a tumour
  double inliers =
      0.0;  ///< tracked features that agree with the model, of those tracked at the start
  double coverage = 0.0;  ///< area of the initial feature cloud still covered by tracked features
  double residual_px = 0.0;  ///< robust scale of the reprojection error of tracked features
};

/// @param initially_tracked number of features that took part in the first frame
Reliability AssessReliability(const RegistrationState& state, const CameraModel& camera,
                              Index initially_tracked);

}  // namespace kerf
