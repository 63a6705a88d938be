#include "Registration/Step.h"

#include "Registration/CutDetection.h"
#include "Registration/ModelUpdate.h"
#include "Registration/OrganMask.h"

namespace kerf {
namespace {

void Begin(const Engine& engine, Stage stage) {
  if (engine.observer) engine.observer->Begin(stage);
}

/// Features that take part: tracked in this frame and bound to the organ.
std::vector<char> Usable(const RegistrationState& state) {
  std::vector<char> usable(state.features.Size());
  for (Index i = 0; i < state.features.Size(); ++i)
    usable[i] = state.features.status[i] == FeatureStatus::Tracked && state.bound.on_surface[i];
  return usable;
}

/// Springs of Eq. (4) between the features and their targets; Kerf's are rays with a weak depth
/// gauge.
Springs FeatureSprings(const RegistrationState& state, const Points& targets,
                       const std::vector<char>& usable, const CameraModel& camera,
                       const MethodOptions& options) {
  Springs springs;
  springs.at = state.bound.embedding;
  springs.targets = targets;
  springs.stiffness.resize(state.features.Size());
  for (Index i = 0; i < state.features.Size(); ++i)
    springs.stiffness[i] = usable[i] ? options.SpringStiffness_g_s2() : 0.0;
  springs.along_factor = options.along_factor;
  springs.robust_scale_mm = options.robust_scale_mm;
  if (options.along_factor != 1.0)
    springs.directions = (targets.rowwise() - camera.Center().transpose()).rowwise().normalized();
  return springs;
}

}  // namespace

RegistrationState Initialize(const Frame& first, const CameraModel& camera, TetMesh mesh,
                             std::vector<Structure> structures, const MethodOptions& options,
                             Engine& engine) {
  RegistrationState state;
  state.frame = first.index;
  state.mesh = std::move(mesh);
  state.structures = std::move(structures);
  state.positions = state.mesh.rest;
  state.velocities = Points::Zero(state.mesh.VertexCount(), 3);
  const BindingSurface surface(state.mesh, state.positions);
  const Image mask = ProjectedMask(BoundarySurface(state.mesh, state.positions), camera);
  state.features = engine.tracker.Detect(first, mask, options.wanted_features);
  state.bound = surface.Bind(state.features.pixels, camera);
  state.neighbors = BuildNeighborGraph(state.bound.rest, options.neighbour_radius_mm);
  engine.solver.Reset(state.mesh, options.material);
  return state;
}

StepReport Step(const Frame& frame, const CameraModel& camera, const MethodOptions& options,
                Engine& engine, RegistrationState* state) {
  StepReport report;
  state->frame = frame.index;
  Begin(engine, Stage::Tracking);
  engine.tracker.Track(frame, &state->features);  // [1] track features frame to frame
  const std::vector<char> usable = Usable(*state);
  for (int repeat = 0; repeat < options.steps_per_frame; ++repeat) {
    Begin(engine, Stage::Targets);
    const Points targets =  // [2] map the tracked pixels to targets P_F¹
        TargetsAtRestDepth(state->features.pixels, state->bound.rest_depth_mm, camera);
    const Points current =  // [3] where the model has its features, P_F^t
        state->bound.embedding.Positions(state->positions, state->mesh.tets);
    Begin(engine, Stage::Detection);
    const MeasuredDivergence divergence =  // [4] Eq. (11) on the neighbourhood graph
        MeasureDivergence(*state, current, targets, usable, options);
    report.divergence_mean_mm = divergence.outliers.mean_mm;
    report.outliers = static_cast<int>(divergence.outliers.pairs.size());
    const auto grown =  // [5] outliers → cut point → cut line
        options.cutting ? DetectCut(divergence, camera, options, state) : std::nullopt;
    if (grown) {  // [6] extrude to S; cut model and internal structures
      CutEvent event = *grown;
      event.report = ApplyCut(state->cuts[event.cut], options, engine, state);
      report.cuts.push_back(event);
    }
    Begin(engine, Stage::Solve);
    report.solve = engine.solver.Solve(  // [7] minimize Eq. (5)
        FeatureSprings(*state, targets, usable, camera, options), {}, options.solve,
        &state->positions, &state->velocities);
  }
  return report;  // [8] the module draws
}

}  // namespace kerf
