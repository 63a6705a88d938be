#include "Registration/CutProbe.h"

#include <algorithm>
#include <cmath>

#include "Registration/CutDetection.h"
#include "Registration/ModelUpdate.h"

namespace kerf {
namespace {

constexpr double kFar_mm = 1000.0;

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
  const Vec3 into = cut.direction.normalized();
  if (!state.uncut->FirstHit({tip - kFar_mm * into, into})) return std::nullopt;  // over the rim
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

/// `cut` with S turned about its line. @param limited its depth is given
std::optional<ModelCut> Turned(const ModelCut& cut, double by_deg, bool limited,
                               const RegistrationState& state, const CameraModel& camera,
                               const CutProbeOptions& probe) {
  const Index n = static_cast<Index>(cut.line.points.rows());
  if (n < 2) return std::nullopt;
  const Vec3 along = (cut.line.points.row(n - 1) - cut.line.points.row(0)).transpose();
  if (along.norm() < 1e-6) return std::nullopt;
  ModelCut turned = cut;
  turned.direction =
      Eigen::AngleAxisd(by_deg * M_PI / 180.0, along.normalized()) * cut.direction.normalized();
  const double slope =
      std::acos(std::clamp(turned.direction.dot(camera.ViewDirection()), -1.0, 1.0));
  if (slope * 180.0 / M_PI > probe.steepest_deg) return std::nullopt;
  if (!limited) turned.depth_mm = ThroughDepth_mm(state.origin->mesh, turned.direction);
  turned.surface = ExtrudeCut(turned.line, turned.direction, turned.depth_mm);
  return turned;
}

/// How well one model follows the tracks after a few more steps.
class Comparison {
 public:
  Comparison(const std::vector<char>& usable, const CameraModel& camera,
             const MethodOptions& options, const CutProbeOptions& probe,
             const RegistrationState& state)
      : usable_(usable), camera_(camera), options_(options), state_(state) {
    fitting_.steps = probe.steps;
    fitting_.renewed_columns = fitting_.after_cut = 0;
    fitting_.newton_steps = 12;
    gain_ = probe.gain;
  }
  /// Remembers the candidate if it is better than all before.
  void Try(const TetMesh& mesh, const Embedding& features, const Points& grip_positions,
           const BetterCut& candidate) {
    if (needed_ < 0.0)
      needed_ = (1.0 - gain_) * Cost(state_.mesh, state_.bound.embedding, state_.grips.positions);
    const double cost = Cost(mesh, features, grip_positions);
    if (cost >= needed_) return;
    needed_ = cost;
    best_ = candidate;
  }
  const std::optional<BetterCut>& Best() const { return best_; }

 private:
  double Cost(const TetMesh& mesh, const Embedding& features, const Points& grip_positions) const {
    GripFit fit = state_.grips;
    fit.positions = grip_positions;
    fit.settled = false;
    BoundFeatures bound = state_.bound;
    bound.embedding = features;
    const auto solver = MakeKerfSolver();
    solver->Reset(mesh, options_.material);
    UpdateGrips(mesh, options_.material, bound, state_.features.pixels, usable_, camera_, fitting_,
                solver.get(), &fit);
    return fit.cost_mm2;
  }
  const std::vector<char>& usable_;
  const CameraModel& camera_;
  const MethodOptions& options_;
  const RegistrationState& state_;
  GripFitOptions fitting_;
  double gain_ = 0.0, needed_ = -1.0;  // the cost to undercut; not known yet
  std::optional<BetterCut> best_;
};

}  // namespace

std::optional<BetterCut> ProbeCuts(const std::vector<char>& usable, const CameraModel& camera,
                                   const MethodOptions& options, const CutProbeOptions& probe,
                                   const TetCutter& cutter, const RegistrationState& state) {
  const bool direction = state.probing.turn, ends = !direction;
  const auto open = [](const ModelCut& c) { return c.in_model && !c.drawn; };
  const bool any = std::any_of(state.cuts.begin(), state.cuts.end(), open);
  if (options.hold_cuts || state.grips.regions.empty() ||
      state.grips.residual_mm < probe.unexplained_mm ||
      state.grips.residual_mm > probe.hopeless_mm ||
      state.grips.strain2 > probe.nonlinear_strain2 || !any ||
      !(ends || (direction && !options.extrusion)))
    return std::nullopt;
  Comparison comparison(usable, camera, options, probe, state);
  Points start;
  if (direction) start = BentByGrips(state.grips, state.origin->mesh.rest);
  for (std::size_t c = 0; c < state.cuts.size(); ++c) {
    const ModelCut& cut = state.cuts[c];
    if (!open(cut)) continue;
    for (int sign : {-1, 1}) {
      BetterCut candidate{static_cast<int>(c), {}, direction};
      if (ends) {
        const auto longer = Longer(cut, sign > 0, probe.step_mm, state);
        if (!longer) continue;
        candidate.instead = *longer;
        TetCutter knife = cutter;
        const TopologyChange change =
            knife.Cut(state.mesh, longer->surface, nullptr, &state.positions);
        if (!change.changed) continue;
        comparison.Try(change.mesh, change.MapEmbedding(state.bound.embedding, state.mesh),
                       change.MapVertexField(state.grips.positions), candidate);
      } else {
        // A direction that cannot be remeshed well has neighbours that can.
        for (double share : {1.0, 0.75, 1.25}) {
          const auto turned = Turned(cut, sign * share * probe.step_deg,
                                     options.cut_depth_mm.has_value(), state, camera, probe);
          if (!turned) continue;
          candidate.instead = *turned;
          std::vector<ModelCut> cuts = state.cuts;
          cuts[c] = *turned;
          const auto model = CutAnew(cuts, options, state, false, &start);
          if (!model) continue;
          comparison.Try(model->mesh, model->features, model->grip_positions, candidate);
          break;
        }
      }
    }
  }
  return comparison.Best();
}

}  // namespace kerf
