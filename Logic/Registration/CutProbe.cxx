#include "Registration/CutProbe.h"

#include "Registration/ModelUpdate.h"

namespace kerf {
namespace {

constexpr double kOnOrgan_mm = 4.0;  // an end farther from the surface is over the rim already

/// `cut`, longer by `by_mm` at its last point (or its first), in the direction it had there.
std::optional<ModelCut> Longer(const ModelCut& cut, bool at_end, double by_mm,
                               const RegistrationState& state) {
  const Index n = static_cast<Index>(cut.line.points.rows());
  if (n < 2) return std::nullopt;
  const Vec3 tip = cut.line.points.row(at_end ? n - 1 : 0).transpose();
  // The direction over some length: the last segment may be very short.
  Vec3 from = tip;
  for (Index i = 1; i < n && (tip - from).norm() < 4.0; ++i)
    from = cut.line.points.row(at_end ? n - 1 - i : i).transpose();
  if ((tip - from).norm() < 1e-6) return std::nullopt;
  const Vec3 next = tip + by_mm * (tip - from).normalized();
  const SurfaceHit there = state.uncut->Closest(tip);
  if (there.distance_mm > kOnOrgan_mm) return std::nullopt;
  ModelCut grown = cut;
  grown.line.points.conservativeResize(n + 1, 3);
  if (at_end) {
    grown.line.points.row(n) = next.transpose();
  } else {
    for (Index i = n; i > 0; --i) grown.line.points.row(i) = cut.line.points.row(i - 1);
    grown.line.points.row(0) = next.transpose();
  }
  grown.surface = ExtrudeCut(grown.line, grown.direction, grown.depth_mm);
  return grown;
}

}  // namespace

std::optional<LongerCut> ProbeCutEnds(const std::vector<char>& usable, const CameraModel& camera,
                                      const MethodOptions& options, const CutProbeOptions& probe,
                                      const TetCutter& cutter, const RegistrationState& state) {
  if (state.grips.regions.empty() || state.grips.residual_mm < probe.unexplained_mm ||
      state.frame % probe.every_frames != 0)
    return std::nullopt;
  GripFitOptions fitting;
  fitting.steps = probe.steps;
  fitting.renewed_columns = 0;
  double best_cost = -1.0;
  std::optional<LongerCut> best;
  for (std::size_t c = 0; c < state.cuts.size(); ++c) {
    if (state.cuts[c].held || state.cuts[c].rejected) continue;
    for (bool at_end : {false, true}) {
      const auto grown = Longer(state.cuts[c], at_end, probe.step_mm, state);
      if (!grown) continue;
      if (best_cost < 0.0) {  // what the cut that there is comes to with as many steps
        GripFit as_is = state.grips;
        const auto solver = MakeKerfSolver();
        solver->Reset(state.mesh, options.material);
        UpdateGrips(state.mesh, options.material, state.bound, state.features.pixels, usable,
                    camera, fitting, solver.get(), &as_is);
        best_cost = (1.0 - probe.gain) * as_is.cost_mm2;
      }
      TetCutter knife = cutter;
      const TopologyChange change =
          knife.Cut(state.mesh, grown->surface, nullptr, &state.positions);
      if (!change.changed) continue;
      BoundFeatures bound = state.bound;
      bound.embedding = change.MapEmbedding(bound.embedding, state.mesh);
      GripFit fit = state.grips;
      fit.positions = change.MapVertexField(fit.positions);
      fit.velocities = change.MapVertexField(fit.velocities);
      const auto solver = MakeKerfSolver();
      solver->Reset(change.mesh, options.material);
      UpdateGrips(change.mesh, options.material, bound, state.features.pixels, usable, camera,
                  fitting, solver.get(), &fit);
      if (fit.cost_mm2 < best_cost) {
        best_cost = fit.cost_mm2;
        best = LongerCut{static_cast<int>(c), *grown};
      }
    }
  }
  return best;
}

}  // namespace kerf
