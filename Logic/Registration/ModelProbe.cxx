#include "Registration/ModelProbe.h"

#include <algorithm>
#include <cmath>

#include "Cutting/Bridges.h"
#include "Registration/CutDetection.h"
#include "Registration/CutLine.h"
#include "Registration/ModelUpdate.h"

namespace kerf {
namespace {

constexpr double kFar_mm = 1000.0;
constexpr double kSameLine_mm = 1.0;  // a line redrawn by less is the same
/// A direction in which S cannot be cut well has neighbours in which it can.
constexpr double kNeighbours_deg[] = {0.0, 0.8, -0.8, 1.6};

/// Where the line of `cut` leads, `by_mm` on from its last point (or its first). @return none where
/// it ends over the rim already
std::optional<Vec3> NextTip(const ModelCut& cut, bool at_end, double by_mm,
                            const RegistrationState& state) {
  const Index n = static_cast<Index>(cut.line.points.rows());
  if (n < 2) return std::nullopt;
  const Vec3 tip = cut.line.points.row(at_end ? n - 1 : 0).transpose();
  // The direction over some length: the last segment may be very short.
  Vec3 from = tip;
  for (Index i = 1; i < n && (tip - from).norm() < 4.0; ++i)
    from = cut.line.points.row(at_end ? n - 1 - i : i).transpose();
  if ((tip - from).norm() < 1e-6) return std::nullopt;
  const Vec3 into = cut.direction.normalized();
  if (!state.uncut->IsHit({tip - kFar_mm * into, into})) return std::nullopt;  // over the rim
  return tip + by_mm * (tip - from).normalized();
}

/// `cut` with S turned about its line. @param limited its depth is given
std::optional<ModelCut> Turned(const ModelCut& cut, double by_deg, bool limited,
                               const RegistrationState& state, const CameraModel& camera,
                               const ModelProbeOptions& probe) {
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
             const MethodOptions& options, const ModelProbeOptions& probe,
             std::shared_ptr<const RegistrationState> state, const std::atomic<bool>* given_up)
      : usable_(usable), camera_(camera), options_(options), state_(std::move(state)) {
    fitting_.steps = probe.steps;
    fitting_.given_up = given_up;
    fitting_.newton_steps = 12;
    fitting_.most_iterations = 0;
    gain_ = probe.gain;
    regrip_gain_ = probe.regrip_gain;
  }
  /// Remembers the candidate if it is better than all before. @return whether it is
  bool Try(const CutModel& model, const ModelChange& candidate) {
    if (needed_ < 0.0)
      needed_ = (1.0 - gain_) * At(state_->mesh, state_->bound.embedding, state_->grips.positions,
                                   0, MakeKerfSolver().get())
                                    .cost_mm2;
    const double cost =
        At(model.mesh, model.features, model.grip_positions, 0, MakeKerfSolver().get()).cost_mm2;
    if (cost >= needed_) return false;
    needed_ = cost;
    Remember(candidate);
    return true;
  }
  bool TryGrips(const std::vector<double>& factors) {
    if (needed_ < 0.0) needed_ = (1.0 - regrip_gain_) * WithGrips(state_->grips).cost_mm2;
    GripFit fitted = WithGrips(Regripped(state_->grips, factors));
    if (fitted.cost_mm2 >= needed_) return false;
    needed_ = fitted.cost_mm2;
    ModelChange change;
    change.by = ModelChange::By::Regripped;
    Remember(change);
    best_->fitted = std::move(fitted);
    return true;
  }
  /// The best; with the model ready to go on from where it has to be cut anew.
  std::optional<BetterModel> Take() {
    if (!best_ || best_->by == ModelChange::By::Regripped) return std::move(best_);
    std::vector<ModelCut> cuts = state_->cuts;
    cuts[best_->cut] = best_->instead;
    const Points start = BentByGrips(state_->grips, state_->origin->mesh.rest);
    auto model = CutAnew(cuts, options_, *state_, true, &start);
    if (!model) return std::nullopt;
    model->solvers = {MakeKerfSolver(), MakeKerfSolver()};
    model->solvers.organ->Reset(model->mesh, options_.material);
    best_->fitted = At(model->mesh, model->features, model->grip_positions, AllColumns(),
                       model->solvers.grips.get());
    model->grip_positions = best_->fitted.positions;
    best_->model = std::move(*model);
    return std::move(best_);
  }

 private:
  void Remember(const ModelChange& change) {
    best_.emplace();
    static_cast<ModelChange&>(*best_) = change;
    best_->then = state_;
  }
  /// `fit` after the steps of a trial, on a model of its own. @param columns sensitivities to
  /// measure anew before
  GripFit Fitted(const TetMesh& mesh, const Embedding& features, GripFit fit, int columns,
                 ElasticSolver* solver) const {
    GripFitOptions fitting = fitting_;
    fitting.renewed_columns = columns;
    fitting.renewal_frames = 1;
    fit.frames_to_renewal = 0;
    fit.settled = fit.torn = false;
    BoundFeatures bound = state_->bound;
    bound.embedding = features;
    solver->Reset(mesh, options_.material);
    UpdateGrips(mesh, options_.material, bound, state_->features.pixels, usable_, camera_, fitting,
                solver, &fit);
    return fit;
  }
  /// On a model with these places, all else as it is.
  GripFit At(const TetMesh& mesh, const Embedding& features, const Points& grip_positions,
             int columns, ElasticSolver* solver) const {
    GripFit fit = state_->grips;
    fit.positions = grip_positions;
    fit.fields.clear();
    return Fitted(mesh, features, std::move(fit), columns, solver);
  }
  /// Held parts, all sensitivities measured with them.
  GripFit WithGrips(const GripFit& fit) const {
    return Fitted(state_->mesh, state_->bound.embedding, fit, AllColumns(), MakeKerfSolver().get());
  }
  int AllColumns() const { return static_cast<int>(state_->grips.sensitivities.cols()); }
  const std::vector<char>& usable_;
  const CameraModel& camera_;
  const MethodOptions& options_;
  std::shared_ptr<const RegistrationState> state_;
  GripFitOptions fitting_;
  double gain_ = 0.0, regrip_gain_ = 0.0, needed_ = -1.0;  // the cost to undercut; not known yet
  std::optional<BetterModel> best_;
};

/// Which cuts may be probed: in the model, and not a surgeon's.
bool Open(const ModelCut& cut) { return cut.in_model && !cut.drawn; }

}  // namespace

bool IsCut(const RegistrationState& state) {
  return std::any_of(state.cuts.begin(), state.cuts.end(),
                     [](const ModelCut& cut) { return cut.in_model; });
}

bool WorthProbing(const MethodOptions& options, const ModelProbeOptions& probe,
                  const RegistrationState& state) {
  if (state.grips.regions.empty() || state.grips.residual_mm > probe.hopeless_mm ||
      state.grips.strain2 > probe.nonlinear_strain2)
    return false;
  if (!IsCut(state))
    return state.grips.strain2 <= probe.regrip_strain2 &&
           state.grips.residual_mm >= std::max(probe.telling_mm, state.probing.regrip_mm);
  return !options.hold_cuts && state.grips.residual_mm >= probe.unexplained_mm &&
         std::any_of(state.cuts.begin(), state.cuts.end(), Open);
}

std::optional<BetterModel> ProbeModel(const std::vector<char>& usable, const CameraModel& camera,
                                      const MethodOptions& options, const ModelProbeOptions& probe,
                                      std::shared_ptr<const RegistrationState> state,
                                      const std::atomic<bool>* given_up) {
  Comparison comparison(usable, camera, options, probe, state, given_up);
  using By = ModelChange::By;
  const Points start = BentByGrips(state->grips, state->origin->mesh.rest);
  const auto go_on = [&] { return !given_up || !*given_up; };
  // What is better so far: the cut, and how it differs from the one in the state.
  std::optional<ModelChange> better;
  const auto cut_now = [&](int c) {
    return better && better->cut == c ? better->instead : state->cuts[c];
  };
  const auto instead_of = [&](int c, ModelCut instead, By by, bool at_end) {
    ModelChange candidate;
    if (better && better->cut == c) {
      candidate.shorter_mm = better->shorter_mm;
      if (better->by != by || better->at_end != at_end) by = By::Redrawn;
    }
    candidate.cut = c;
    candidate.instead = std::move(instead);
    candidate.by = by;
    candidate.at_end = at_end;
    return candidate;
  };
  const auto cut_along = [&](const ModelChange& candidate) {
    std::vector<ModelCut> cuts = state->cuts;
    cuts[candidate.cut] = candidate.instead;
    return CutAnew(cuts, options, *state, false, &start);
  };
  /// @return whether it is better than all before
  const auto try_anew = [&](ModelChange candidate) {
    const ModelCut wanted = candidate.instead;
    std::optional<CutModel> model;
    for (double by_deg : kNeighbours_deg) {
      if (!go_on() || (by_deg != 0.0 && options.extrusion)) break;
      ModelChange neighbour = candidate;
      if (by_deg != 0.0) {
        const auto turned =
            Turned(wanted, by_deg, options.cut_depth_mm.has_value(), *state, camera, probe);
        if (!turned) continue;
        neighbour.instead = *turned;
      }
      auto cut = cut_along(neighbour);
      if (!cut) continue;
      const bool joined = JoinedAcross(cut->mesh, neighbour.instead.surface);
      if (model && joined) continue;
      model = std::move(cut);
      candidate = std::move(neighbour);
      if (!joined) break;
    }
    if (!model || !comparison.Try(*model, candidate)) return false;
    better = std::move(candidate);
    return true;
  };
  const auto mend = [&](int c) {
    if (JoinedAcross(state->mesh, state->cuts[c].surface))
      try_anew(instead_of(c, cut_now(c), By::Turned, false));
  };
  const auto redraw = [&](int c) {
    ModelCut other = cut_now(c);
    double off_mm = 0.0;
    for (Index i = 0; i < other.redrawn.rows(); ++i)
      off_mm =
          std::max(off_mm, DistanceToLine(other.line.points, other.redrawn.row(i).transpose()));
    if (off_mm < kSameLine_mm) return;
    other.line.points = other.redrawn;
    other.surface = ExtrudeCut(other.line, other.direction, other.depth_mm);
    try_anew(instead_of(c, other, By::Redrawn, false));
  };
  /// @return whether it helped
  const auto lengthen = [&](int c, bool at_end) {
    bool helped = false;
    for (int step = 0; step < probe.most_steps && go_on(); ++step) {
      ModelCut longer = cut_now(c);
      const auto tip = NextTip(longer, at_end, probe.step_mm, *state);
      if (!tip) break;
      longer.line.points = LedOn(longer.line.points, at_end, *tip);
      longer.surface = ExtrudeCut(longer.line, longer.direction, longer.depth_mm);
      if (!try_anew(instead_of(c, longer, By::Longer, at_end))) break;
      helped = true;
    }
    return helped;
  };
  const auto shorten = [&](int c, bool at_end) {
    if (!NextTip(cut_now(c), at_end, 0.0, *state)) return;
    for (int step = 0; step < probe.most_steps && go_on(); ++step) {
      ModelCut shorter = cut_now(c);
      shorter.line.points = Shortened(shorter.line.points, at_end, probe.step_mm);
      if (shorter.line.points.rows() < 2) return;
      shorter.surface = ExtrudeCut(shorter.line, shorter.direction, shorter.depth_mm);
      ModelChange candidate = instead_of(c, shorter, By::Shorter, at_end);
      candidate.shorter_mm[at_end] += probe.step_mm;
      if (!try_anew(std::move(candidate))) return;
    }
  };
  /// Turned by some steps either way; where that alone does not help, with one of its ends longer
  /// or shorter: a wrong direction is made up for by a wrong length, and the other way round.
  const auto turn = [&](int c, int sign, const ModelCut& from) {
    const auto also = [&](const ModelCut& turned, bool at_end) {
      const auto tip = NextTip(turned, at_end, probe.step_mm, *state);
      if (!tip) return;
      for (By by : {By::Longer, By::Shorter}) {
        ModelCut other = turned;
        other.line.points = by == By::Longer ? LedOn(other.line.points, at_end, *tip)
                                             : Shortened(other.line.points, at_end, probe.step_mm);
        if (other.line.points.rows() < 2 || !go_on()) continue;
        other.surface = ExtrudeCut(other.line, other.direction, other.depth_mm);
        ModelChange candidate = instead_of(c, other, By::Redrawn, at_end);
        candidate.shorter_mm = {};
        if (by == By::Shorter) candidate.shorter_mm[at_end] = probe.step_mm;
        try_anew(std::move(candidate));
      }
    };
    for (int step = 1; step <= probe.most_steps && go_on(); ++step) {
      const auto turned = Turned(from, sign * step * probe.step_deg,
                                 options.cut_depth_mm.has_value(), *state, camera, probe);
      if (!turned) return;
      ModelChange candidate = instead_of(c, *turned, By::Turned, false);
      candidate.by = By::Turned;
      candidate.shorter_mm = {};
      if (try_anew(std::move(candidate))) continue;
      if (step == 1)
        for (bool at_end : {false, true}) also(*turned, at_end);
      return;
    }
  };
  if (!IsCut(*state)) {
    // Both ends alike, then each by itself, in turn.
    for (double factor : {0.7, 0.85, 1.18, 1.4}) {
      const int which = state->probing.regrips % 3;
      if (go_on()) comparison.TryGrips({which == 2 ? 1.0 : factor, which == 1 ? 1.0 : factor});
    }
    return go_on() ? comparison.Take() : std::nullopt;
  }
  for (int c = 0; c < static_cast<int>(state->cuts.size()); ++c) {
    if (!Open(state->cuts[c])) continue;
    mend(c);
    if (state->probing.turn) {
      const ModelCut from = cut_now(c);
      for (int sign : {-1, 1}) turn(c, sign, from);
    } else {
      redraw(c);
      for (bool at_end : {false, true})
        if (!lengthen(c, at_end)) shorten(c, at_end);
    }
  }
  if (!go_on()) return std::nullopt;
  auto best = comparison.Take();
  return go_on() ? std::move(best) : std::nullopt;  // given up, it is not whole
}

}  // namespace kerf
