#include "Registration/CutSearch.h"

#include <tbb/task_arena.h>

#include "Registration/CutLine.h"

namespace kerf {
namespace {

constexpr double kShortest_mm = 0.5;  // growth

}  // namespace

bool CutSearch::Begin(const std::vector<char>& usable, const CameraModel& camera,
                      const MethodOptions& options, const TetCutter& cutter,
                      const RegistrationState& state) {
  Drop();
  const CutProbeOptions probe;
  if (!WorthProbing(options, probe, state)) return false;
  given_up_ = false;
  auto then = std::make_shared<const RegistrationState>(state);
  const std::atomic<bool>* given_up = &given_up_;
  found_ = std::async(std::launch::async, [=] {
    tbb::task_arena alone(1);  // leaves the other cores to the frames
    return alone.execute(
        [&] { return ProbeCuts(usable, camera, options, probe, cutter, then, given_up); });
  });
  return true;
}

std::optional<BetterCut> CutSearch::Finish() {
  if (!found_.valid()) return std::nullopt;
  return found_.get();
}

void CutSearch::Drop() {
  if (!found_.valid()) return;
  given_up_ = true;
  found_.wait();
  found_ = {};
}

CutEvent TakeOver(BetterCut better, const MethodOptions& options, Engine& engine,
                  RegistrationState* state) {
  CutEvent event;
  event.cut = better.cut;
  event.point = better.instead.line.points.row(0).transpose();
  ModelCut& cut = state->cuts[better.cut];
  const auto end = [&](const ModelCut& c) {
    return Vec3(c.line.points.row(better.at_end ? c.line.points.rows() - 1 : 0).transpose());
  };
  const Vec3 now = end(cut), then = end(better.then->cuts[better.cut]), tip = end(better.instead);
  if (better.by == BetterCut::By::Longer) {
    // It may have grown there meanwhile, perhaps further.
    if ((tip - now).dot((tip - then).normalized()) < kShortest_mm) return event;
    cut.line.points = LedOn(cut.line.points, better.at_end, tip);
    cut.surface = ExtrudeCut(cut.line, cut.direction, cut.depth_mm);
    event.report = ApplyCut(cut, options, engine, state);
    return event;
  }
  if (better.by == BetterCut::By::Shorter) {
    if (now != then) return event;  // it goes on there
    cut.line.points = Shortened(cut.line.points, better.at_end, better.by_mm);
    cut.too_far_mm[better.at_end] += better.by_mm;
  }
  cut.direction = better.instead.direction;
  cut.depth_mm = better.instead.depth_mm;
  cut.surface = ExtrudeCut(cut.line, cut.direction, cut.depth_mm);
  GripFit fit = std::move(better.fitted);
  const Points before = BentByGrips(fit, better.model.mesh.rest);
  for (std::size_t g = 0; g < fit.motions.size(); ++g)  // the grips have moved on since
    fit.motions[g] =
        state->grips.motions[g] * better.then->grips.motions[g].inverse() * fit.motions[g];
  better.model.grip_positions += BentByGrips(fit, better.model.mesh.rest) - before;
  better.model.positions = better.model.grip_positions;
  fit.trust = state->grips.trust;
  state->grips = std::move(fit);
  Adopt(std::move(better.model), options, engine, state);
  state->grips.stale_columns = 0;  // measured on this model
  event.report.done = true;
  for (std::size_t c = 0; c < state->cuts.size(); ++c) {  // and cuts may have grown
    const ModelCut& other = state->cuts[c];
    const bool known = c < better.then->cuts.size();
    const ModelCut* cut_along = static_cast<int>(c) == better.cut ? &better.instead
                                : known                           ? &better.then->cuts[c]
                                                                  : nullptr;
    if (other.in_model && !other.rejected &&
        !(cut_along && cut_along->line.points.rows() == other.line.points.rows()))
      ApplyCut(other, options, engine, state);
  }
  return event;
}

}  // namespace kerf
