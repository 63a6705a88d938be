#pragma once

#include <vector>

#include "Registration/Divergence.h"
#include "Registration/Step.h"

namespace kerf {

/// Eq. (11) in one iteration, with its outliers.
struct MeasuredDivergence {
  Eigen::VectorXd mu;
  Outliers outliers;
};

MeasuredDivergence MeasureDivergence(const RegistrationState& state, const Points& current,
                                     const Points& targets, const std::vector<char>& usable,
                                     const MethodOptions& options);

/// The paper's detection: outliers → cut point (projected to the rest surface) → neighbours that
/// cross its sphere are removed → the polygon grows at its nearest end → S grows with it. One
/// sequence of cut points.
/// @return one event when the committed line grew, none otherwise; `state->cuts` holds the new line
/// and S
std::vector<CutEvent> DetectCut(const MeasuredDivergence& divergence, const CameraModel& camera,
                                const MethodOptions& options, RegistrationState* state);

/// Reach of S below the surface that goes through the whole organ along `direction`.
double ThroughDepth_mm(const TetMesh& mesh, const Vec3& direction);

}  // namespace kerf
