#include "Registration/ModelSearch.h"

#include <sys/resource.h>
#include <tbb/task_arena.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>

#include "Registration/CutLine.h"

namespace kerf {
namespace {

/// Of the scheduler: frames get three quarters of a core that they share with a search.
constexpr int kNiceness = 5;
constexpr double kShortest_mm = 0.5;  // growth
constexpr double kStraight = 0.8;     // cosine of the bend where an end has grown meanwhile

}  // namespace

bool ModelSearch::Begin(const std::vector<char>& usable, const CameraModel& camera,
                        const MethodOptions& options, const RegistrationState& state) {
  Drop();
  const ModelProbeOptions probe;
  if (!WorthProbing(options, probe, state)) return false;
  given_up_ = std::make_shared<std::atomic<bool>>(false);
  auto then = std::make_shared<const RegistrationState>(state);
  found_ = std::async(std::launch::async, [=, given_up = given_up_] {
    // Frames come first. Where the priority cannot be changed, the search is as good.
    setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), kNiceness);
    tbb::task_arena alone(1);
    return alone.execute(
        [&] { return ProbeModel(usable, camera, options, probe, then, given_up.get()); });
  });
  return true;
}

std::optional<BetterModel> ModelSearch::Finish() {
  if (!found_.valid()) return std::nullopt;
  return found_.get();
}

void ModelSearch::Drop() {
  given_up_ones_.erase(std::remove_if(given_up_ones_.begin(), given_up_ones_.end(),
                                      [](const Result& search) {
                                        return search.wait_for(std::chrono::seconds(0)) ==
                                               std::future_status::ready;
                                      }),
                       given_up_ones_.end());
  if (!found_.valid()) return;
  *given_up_ = true;
  given_up_ones_.push_back(std::move(found_));
}

CutEvent TakeOver(BetterModel better, const MethodOptions& options, Engine& engine,
                  RegistrationState* state) {
  CutEvent event;
  if (better.by == ModelChange::By::Regripped) {
    if (state->mesh.VertexCount() == better.fitted.positions.rows())
      state->grips =
          MovedOn(std::move(better.fitted), better.then->grips, state->grips, state->mesh.rest);
    return event;
  }
  event.cut = better.cut;
  event.point = better.instead.line.points.row(0).transpose();
  ModelCut& cut = state->cuts[better.cut];
  const auto end = [&](const ModelCut& c) {
    return Vec3(c.line.points.row(better.at_end ? c.line.points.rows() - 1 : 0).transpose());
  };
  const Vec3 now = end(cut), then = end(better.then->cuts[better.cut]), tip = end(better.instead);
  if (better.by == ModelChange::By::Longer) {
    // It may have grown there meanwhile, perhaps further, or elsewhere.
    const double on_mm = (tip - now).dot((tip - then).normalized());
    if (on_mm < kShortest_mm || (now != then && on_mm < kStraight * (tip - now).norm()))
      return event;
  }
  if (better.by == ModelChange::By::Shorter && now != then) return event;  // it goes on there
  if (better.by != ModelChange::By::Turned) cut.line = better.instead.line;
  for (int k = 0; k < 2; ++k) cut.too_far_mm[k] += better.shorter_mm[k];
  cut.direction = better.instead.direction;
  cut.depth_mm = better.instead.depth_mm;
  cut.surface = ExtrudeCut(cut.line, cut.direction, cut.depth_mm);
  GripFit fit =
      MovedOn(std::move(better.fitted), better.then->grips, state->grips, better.model.mesh.rest);
  better.model.positions = better.model.grip_positions = fit.positions;
  state->grips = std::move(fit);
  event.report.done = true;
  event.report.reason = better.model.uncut[better.cut];
  event.report.partial = !event.report.reason.empty();
  Adopt(std::move(better.model), options, engine, state);
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
