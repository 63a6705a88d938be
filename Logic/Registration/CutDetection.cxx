#include "Registration/CutDetection.h"

#include <algorithm>

#include "Registration/ModelUpdate.h"

namespace kerf {

MeasuredDivergence MeasureDivergence(const RegistrationState& state, const Points& current,
                                     const Points& targets, const std::vector<char>& usable,
                                     const MethodOptions& options) {
  MeasuredDivergence out;
  out.mu = Divergence(state.neighbors, current, targets, usable);
  out.outliers = FindOutliers(out.mu, options.tau, options.noise_floor_mm);
  KeepOpposed(state.neighbors, current, targets, &out.outliers);
  return out;
}

double ThroughDepth_mm(const TetMesh& mesh, const Vec3& direction) {
  const Eigen::VectorXd along = mesh.rest * direction;
  return along.maxCoeff() - along.minCoeff() + 5.0;
}

std::vector<CutEvent> DetectCut(const MeasuredDivergence& divergence, const CameraModel& camera,
                                const MethodOptions& options, RegistrationState* state) {
  const auto point = CutPoint(divergence.outliers, divergence.mu, state->neighbors,
                              state->bound.rest, options.outliers);
  if (!point) return {};
  state->neighbors =
      RemoveCrossing(state->neighbors, state->bound.rest, *point, options.cut_radius_mm);
  CutEvent event;
  event.point = *point;
  if (state->cuts.empty() || state->cuts.back().rejected || state->cuts.back().drawn) {
    state->cuts.emplace_back();
    state->cuts.back().detected_frame = state->frame;
    state->cuts.back().confidence = 1.0;
    state->cuts.back().held = options.hold_cuts;
    event.first = true;
  }
  ModelCut& cut = state->cuts.back();
  event.cut = static_cast<int>(state->cuts.size()) - 1;
  if (!cut.polygon.Insert(*point, options.cut_radius_mm)) return {};
  cut.direction = options.extrusion ? *options.extrusion : camera.ViewDirection();
  cut.view = camera.ViewDirection();
  cut.depth_mm = options.cut_depth_mm.value_or(ThroughDepth_mm(state->mesh, cut.direction));
  cut.line = cut.polygon.Committed();
  cut.surface = ExtrudeCut(cut.line, cut.direction, cut.depth_mm);
  return {event};
}

}  // namespace kerf
