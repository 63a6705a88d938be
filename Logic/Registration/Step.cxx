#include "Registration/Step.h"

#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <optional>

#include "Registration/CutDetection.h"
#include "Registration/JumpDetection.h"
#include "Registration/ModelSearch.h"
#include "Registration/ModelUpdate.h"
#include "Registration/OrganMask.h"
#include "Registration/OrganSearch.h"
#include "Registration/Untangle.h"

namespace kerf {
namespace {

constexpr int kSearchFrames = 8;       // what a search is given; live, a late one has longer
constexpr double kRegripGrowth = 1.4;  // of the residual: then the held parts are tried again
// In a frame with a cut, which costs time itself: Newton steps, and iterations of organ and grips.
constexpr int kNewtonStepsAtCuts = 1, kIterationsAtCuts = 16, kGripIterationsAtCuts = 12;
constexpr int kLongestPause_frames = 8;  // between searches in vain

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

/// Median motion of the features since `before`, at their depth.
double MedianStep_mm(const Pixels& before, const RegistrationState& state,
                     const std::vector<char>& usable, const CameraModel& camera) {
  std::vector<double> steps;
  for (Index i = 0; i < state.features.Size(); ++i)
    if (usable[i])
      steps.push_back((state.features.pixels.row(i) - before.row(i)).norm() *
                      state.bound.rest_depth_mm[i] / camera.fx);
  if (steps.empty()) return 0.0;
  std::nth_element(steps.begin(), steps.begin() + steps.size() / 2, steps.end());
  return steps[steps.size() / 2];
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

/// The depth that springs along the lines of sight pull to: that at rest, or what the grips say as
/// far as they are believed.
Eigen::VectorXd GaugeDepths_mm(const RegistrationState& state, const CameraModel& camera) {
  Eigen::VectorXd depth = state.bound.rest_depth_mm;
  if (!(state.grips.trust > 0.0)) return depth;
  const Points held = state.bound.embedding.Positions(state.grips.positions, state.mesh.tets);
  for (Index i = 0; i < depth.size(); ++i)
    depth[i] += state.grips.trust * (camera.Depth(held.row(i).transpose()) - depth[i]);
  return depth;
}

/// The held parts stay where the fit has them, as far as it is believed. A part without features
/// (behind the instrument that holds it) would slip from where nothing else keeps it: there it is
/// enough to believe what the fit says across the lines of sight, at the gauged depth.
Fixations HeldByGrips(const RegistrationState& state, const std::vector<char>& usable,
                      const CameraModel& camera, const MethodOptions& options) {
  constexpr int kFewFeatures = 3;
  Fixations held;
  std::vector<Vec3> targets;
  double trust = 0.0;
  for (const GripRegion& region : state.grips.regions) {
    GripRegion outer_half = region;
    outer_half.from_mm += 0.5 * (region.end_mm - region.from_mm);
    int features = 0;
    for (Index i = 0; i < state.bound.rest.rows(); ++i)
      features += usable[i] && outer_half.Holds(state.bound.rest.row(i).transpose());
    const double here = features < kFewFeatures
                            ? std::max(state.grips.trust, state.grips.trust_across)
                            : state.grips.trust;
    if (!(here > 0.0)) continue;
    trust = std::max(trust, here);
    for (Index v : VerticesIn(region, state.mesh.rest)) {
      const Vec3 place = state.grips.positions.row(v).transpose();
      const double fitted = camera.Depth(place),
                   rest = camera.Depth(Vec3(state.mesh.rest.row(v).transpose())),
                   depth = rest + state.grips.trust * (fitted - rest);
      held.vertices.push_back(v);
      targets.push_back(features < kFewFeatures
                            ? Vec3(camera.Center() + depth / fitted * (place - camera.Center()))
                            : place);
    }
  }
  held.targets.resize(targets.size(), 3);
  for (std::size_t k = 0; k < targets.size(); ++k) held.targets.row(k) = targets[k].transpose();
  held.stiffness_g_s2 = trust * options.SpringStiffness_g_s2();
  return held;
}

/// Where the model has its features in the image; the tracker finds hidden ones again with it.
Pixels ProjectedFeatures(const RegistrationState& state, const CameraModel& camera) {
  const Points current = state.bound.embedding.Positions(state.positions, state.mesh.tets);
  Pixels out(current.rows(), 2);
  for (Index i = 0; i < current.rows(); ++i)
    out.row(i) = camera.Project(current.row(i).transpose()).transpose();
  return out;
}

/// Springs that draw the model's outline to the organ's outline in the image.
void AddSilhouette(const SilhouetteTargets& found, const CameraModel& camera,
                   const MethodOptions& options, Springs* springs) {
  const Index n = springs->at.Size(), m = found.at.Size();
  springs->at.tet.insert(springs->at.tet.end(), found.at.tet.begin(), found.at.tet.end());
  springs->at.weights.conservativeResize(n + m, 4);
  springs->at.weights.bottomRows(m) = found.at.weights;
  springs->targets.conservativeResize(n + m, 3);
  springs->targets.bottomRows(m) = found.targets;
  springs->stiffness.conservativeResize(n + m);
  springs->stiffness.tail(m) = options.silhouette_factor * options.SpringStiffness_g_s2() *
                               std::min(1.0, double(n) / std::max<Index>(1, m)) * found.confidence;
  springs->directions.conservativeResize(n + m, 3);
  springs->directions.bottomRows(m) =
      (found.targets.rowwise() - camera.Center().transpose()).rowwise().normalized();
}

/// How well the outline fits before it is drawn.
void NoteOutline(const SilhouetteTargets& seen, const RegistrationState& state,
                 StepReport* report) {
  const Points model = seen.at.Positions(state.positions, state.mesh.tets);
  report->outline_points = static_cast<int>(model.rows());
  Index off = 0;
  for (Index i = 0; i < model.rows(); ++i)
    off += (seen.targets.row(i) - model.row(i)).norm() > 0.99 * kOutlineOff_mm;
  report->outline_off = double(off) / std::max<Index>(1, model.rows());
}

/// Camera x, y of world points, mm.
Pixels Lateral(const Points& world, const CameraModel& camera) {
  Pixels out(world.rows(), 2);
  for (Index i = 0; i < world.rows(); ++i)
    out.row(i) = (camera.camera_from_world * Vec3(world.row(i).transpose())).head<2>().transpose();
  return out;
}

/// Steps [4] and [5]: by Eq. (11), as the paper does, or by displacement jumps.
std::vector<CutEvent> Detect(const Points& current, const Points& targets,
                             const std::vector<char>& usable, const CameraModel& camera,
                             const MethodOptions& options, RegistrationState* state,
                             StepReport* report) {
  if (options.method == Method::Kerf) {
    if (!options.cutting) return {};
    return DetectCutsByJumps(Lateral(targets, camera), usable, camera, options, state);
  }
  const MeasuredDivergence divergence =
      MeasureDivergence(*state, current, targets, usable, options);
  report->divergence_mean_mm = divergence.outliers.mean_mm;
  report->outliers = static_cast<int>(divergence.outliers.pairs.size());
  if (!options.cutting) return {};
  return DetectCut(divergence, camera, options, state);
}

/// Whether what the running search found is to be taken over now.
bool IsDue(const RegistrationState& state) {
  return state.probing.due_frame >= 0 && state.frame >= state.probing.due_frame;
}

/// Cuts as the grips say they are: longer, or turned. The search runs beside the frames.
void Refine(const std::vector<char>& usable, const CameraModel& camera,
            const MethodOptions& options, Engine& engine, RegistrationState* state,
            StepReport* report) {
  ModelProbing& probing = state->probing;
  if (probing.due_frame >= 0 && probing.of_grips && IsCut(*state)) {  // answered by the cut
    engine.search->Drop();
    probing.due_frame = -1;
  }
  if (probing.due_frame < 0) {
    if (!report->cuts.empty()) {  // what grew is probed soon
      probing.next_frame = state->frame + 1;
      probing.pause_frames = 0;
      probing.turn = false;
      return;
    }
    if (state->frame < probing.next_frame) return;
    if (engine.search->Begin(usable, camera, options, *state)) {
      probing.due_frame = state->frame + kSearchFrames;
      probing.of_grips = !IsCut(*state);
    }
    return;
  }
  if (!IsDue(*state) || options.hold_search) return;
  probing.due_frame = -1;
  if (engine.observer) engine.observer->Wait();
  auto better = engine.search->Finish();
  Begin(engine, Stage::Solve);
  if (better) {
    const CutEvent event = TakeOver(std::move(*better), options, engine, state);
    if (event.report.done) report->cuts.push_back(event);
    probing.pause_frames = 0;
  } else if (probing.turn) {
    probing.pause_frames = std::min(2 * probing.pause_frames + 1, kLongestPause_frames);
  }
  if (probing.of_grips) {
    probing.regrip_mm = kRegripGrowth * state->grips.residual_mm;
    ++probing.regrips;
    probing.next_frame = state->frame + 1;
    return;
  }
  probing.turn = !probing.turn && !options.extrusion;  // a given direction stays
  probing.next_frame = state->frame + (probing.turn ? 0 : probing.pause_frames);
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
  Points rest_camera(state.bound.rest.rows(), 3);
  for (Index i = 0; i < rest_camera.rows(); ++i)
    rest_camera.row(i) =
        (camera.camera_from_world * Vec3(state.bound.rest.row(i).transpose())).transpose();
  state.evidence = BeginEvidence(rest_camera, state.bound.on_surface);
  state.origin = std::make_shared<const UncutModel>(
      UncutModel{state.mesh, state.bound.embedding, state.structures});
  state.uncut = std::make_shared<SurfaceTree>(BoundarySurface(state.mesh, state.mesh.rest));
  state.blind_outline.resize(0, 3);
  state.boundary = MakeBoundaryTopology(state.mesh, state.blind_outline);
  if (options.silhouette_factor > 0.0 && engine.segmenter && first.image) {
    const SilhouetteTargets seen =
        FindSilhouette(state.boundary, state.mesh, state.positions, camera, mask,
                       engine.segmenter->Segment(first, mask), options.silhouette_reach_px);
    state.blind_outline = BlindOutline(seen, state.mesh, camera);
    state.boundary = MakeBoundaryTopology(state.mesh, state.blind_outline);
  }
  engine.solvers.organ->Reset(state.mesh, options.material);
  if (options.grips && engine.solvers.grips)
    state.grips =
        BeginGrips(state.mesh, state.bound, options.material, {}, engine.solvers.grips.get());
  return state;
}

StepReport Step(const Frame& frame, const CameraModel& camera, const MethodOptions& options,
                Engine& engine, RegistrationState* state) {
  StepReport report;
  state->frame = frame.index;
  // The organ is looked for from where the last frame left the model, beside the steps up to [6].
  std::optional<OrganSearch> search;
  if (options.silhouette_factor > 0.0 && engine.segmenter && frame.image)
    search.emplace(*engine.segmenter, frame, camera);
  if (search) search->Begin({state->positions, state->boundary.triangles});
  Begin(engine, Stage::Tracking);
  const Pixels before = state->features.pixels;
  engine.tracker.Track(frame, &state->features);  // [1] track features frame to frame
  const std::vector<char> usable = Usable(*state);
  report.leap_mm = MedianStep_mm(before, *state, usable, camera);
  for (int repeat = 0; repeat < options.steps_per_frame; ++repeat) {
    Begin(engine, Stage::Targets);
    const Points targets =  // [2] map the tracked pixels to targets P_F¹
        TargetsAtRestDepth(state->features.pixels, state->bound.rest_depth_mm, camera);
    const Points current =  // [3] where the model has its features, P_F^t
        state->bound.embedding.Positions(state->positions, state->mesh.tets);
    Begin(engine, Stage::Detection);
    // [4] divergence of neighbours and [5] outliers → cut point → cut line
    for (CutEvent& event : Detect(current, targets, usable, camera, options, state, &report)) {
      if (!state->cuts[event.cut].held)  // [6] S cuts model
        event.report = ApplyCut(state->cuts[event.cut], options, engine, state);  // and structures
      report.cuts.push_back(event);
    }
    const auto is_cut = [&] {
      return std::any_of(report.cuts.begin(), report.cuts.end(),
                         [](const CutEvent& event) { return event.report.done; });
    };
    const bool cut_now = is_cut();
    Begin(engine, Stage::Solve);
    const bool gripped = !state->grips.regions.empty() && engine.solvers.grips;
    GripFitOptions grip_options;
    if (cut_now) {
      grip_options.newton_steps = kNewtonStepsAtCuts;
      grip_options.most_iterations = kGripIterationsAtCuts;
      grip_options.renewed_columns = 0;
    }
    const auto update_grips = [&] {
      UpdateGrips(state->mesh, options.material, state->bound, state->features.pixels, usable,
                  camera, grip_options, engine.solvers.grips.get(), &state->grips);
    };
    const auto refine = [&] {
      if (options.cutting && engine.search) Refine(usable, camera, options, engine, state, &report);
    };
    // Grips that only settle, since the organ has just been cut, do so beside the organ's own
    // solve, which goes by what they said before; unless a search is to be taken over in between.
    const bool due = IsDue(*state) && !options.hold_search;
    const bool beside = gripped && cut_now && SettlesOnly(state->grips) && !due;
    if (gripped && !beside) {
      // A cut that a search found comes with grips of its own, moved on to where they were in the
      // last frame: that is this frame's update.
      const std::size_t cuts_before = report.cuts.size();
      if (due) refine();
      if (report.cuts.size() > cuts_before)
        state->grips.waited = true;
      else
        update_grips();
      if (!due) refine();
      Begin(engine, Stage::Solve);  // what was taken over may have been cut further
    }
    const Points gauged =
        TargetsAtRestDepth(state->features.pixels, GaugeDepths_mm(*state, camera), camera);
    Springs springs = FeatureSprings(*state, gauged, usable, camera, options);
    if (search) {
      auto& [model, organ] = search->Wait();
      // The model has changed since; where the organ is seen has not.
      if (repeat > 0 || !report.cuts.empty())
        model = ProjectedMask({state->positions, state->boundary.triangles}, camera);
      const SilhouetteTargets seen =
          FindSilhouette(state->boundary, state->mesh, state->positions, camera, model, organ,
                         options.silhouette_reach_px);
      NoteOutline(seen, *state, &report);
      AddSilhouette(seen, camera, options, &springs);
    }
    const Fixations held = HeldByGrips(*state, usable, camera, options);
    SolveOptions most = options.solve;
    if (options.method == Method::Kerf && is_cut()) {
      most.max_newton_steps = kNewtonStepsAtCuts;
      most.most_iterations = most.most_iterations > 0
                                 ? std::min(most.most_iterations, kIterationsAtCuts)
                                 : kIterationsAtCuts;
    }
    const auto solve = [&] {
      report.solve = engine.solvers.organ->Solve(springs, held, most,  // [7] minimize Eq. (5)
                                                 &state->positions, &state->velocities);
    };
    if (beside) {
      tbb::parallel_invoke(solve, update_grips);
      refine();
    } else {
      solve();
    }
  }
  report.untangled = Untangle(state->mesh, &state->positions);
  engine.tracker.Predict(ProjectedFeatures(*state, camera));
  return report;  // [8] the module draws
}

}  // namespace kerf
