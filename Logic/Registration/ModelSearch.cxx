#include "Registration/ModelSearch.h"

#include <tbb/task_arena.h>

#include <algorithm>
#include <chrono>

#include "Core/ThreadPriority.h"
#include "Registration/CutLine.h"

namespace kerf {
namespace {

/// An idle search is looked after so often, and has to get this share of a core in that time.
constexpr std::chrono::milliseconds kLook{20}, kPatience{500};
constexpr double kLeastShare = 0.15;
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
  const auto search = [=](const std::atomic<bool>* given_up) {
    return ProbeModel(usable, camera, options, probe, then, given_up);
  };
  found_ = std::async(std::launch::async,
                      [=, given_up = given_up_] { return BehindOthers(search, *given_up); });
  return true;
}

ModelSearch::Answer ModelSearch::BehindOthers(
    const std::function<std::optional<BetterModel>(const std::atomic<bool>*)>& search,
    const std::atomic<bool>& given_up) {
  const auto leave = std::make_shared<std::atomic<bool>>(false);
  auto begun = std::make_shared<std::promise<std::function<double()>>>();
  auto clock_of = begun->get_future();
  Answer answer;
  Result idle = std::async(std::launch::async, [=] {
    begun->set_value(ProcessorClock());
    WorkWhenIdle();  // frames come first, and what draws them
    tbb::task_arena alone(1);
    return alone.execute([&] { return search(leave.get()); });
  });
  const std::function<double()> clock = clock_of.get();
  for (double before_s = clock();;) {
    for (auto waited = kLook; waited <= kPatience && !given_up; waited += kLook)
      if (idle.wait_for(kLook) == std::future_status::ready) {
        answer.better = idle.get();
        return answer;
      }
    const double now_s = clock();
    const double wanted_s = kLeastShare * std::chrono::duration<double>(kPatience).count();
    if (given_up || now_s - before_s < wanted_s) break;
    before_s = now_s;
  }
  *leave = true;
  answer.left_behind = std::move(idle);
  if (given_up) return answer;
  StepBehindOthers();
  StepBehindOthers();
  tbb::task_arena alone(1);
  answer.better = alone.execute([&] { return search(&given_up); });
  return answer;
}

std::optional<BetterModel> ModelSearch::Finish() {
  Clear();
  if (!found_.valid()) return std::nullopt;
  Answer answer = found_.get();
  if (answer.left_behind.valid()) left_behind_.push_back(std::move(answer.left_behind));
  return std::move(answer.better);
}

void ModelSearch::Clear() {
  const auto ended = [](const auto& thread) {
    return thread.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
  };
  for (auto search = given_up_ones_.begin(); search != given_up_ones_.end();) {
    if (!ended(*search)) {
      ++search;
      continue;
    }
    std::future<Answer> given_up = std::move(*search);
    search = given_up_ones_.erase(search);
    try {
      if (Answer answer = given_up.get(); answer.left_behind.valid())
        left_behind_.push_back(std::move(answer.left_behind));
    } catch (const std::exception&) {  // nobody waits for what it found, or why it did not
    }
  }
  left_behind_.erase(std::remove_if(left_behind_.begin(), left_behind_.end(), ended),
                     left_behind_.end());
}

void ModelSearch::Drop() {
  Clear();
  if (!found_.valid()) return;
  *given_up_ = true;
  given_up_ones_.push_back(std::move(found_));
}

namespace {

Vec3 EndOf(const ModelCut& cut, bool at_end) {
  return cut.line.points.row(at_end ? cut.line.points.rows() - 1 : 0).transpose();
}

bool HasGrown(const ModelCut& then, const ModelCut& now, bool at_end) {
  return (EndOf(now, at_end) - EndOf(then, at_end)).norm() >= kShortest_mm;
}

/// The line that was found, led on to where `now` has grown beyond it since `then`.
Points WithGrowth(const ModelCut& found, const ModelCut& then, const ModelCut& now) {
  Points line = found.line.points;
  for (const bool at_end : {false, true}) {
    if (!HasGrown(then, now, at_end)) continue;
    const Vec3 tip = EndOf(now, at_end), on = (tip - EndOf(then, at_end)).normalized();
    if ((tip - EndOf(found, at_end)).dot(on) >= kShortest_mm) line = LedOn(line, at_end, tip);
  }
  return line;
}

}  // namespace

CutEvent TakeOver(BetterModel better, const MethodOptions& options, Engine& engine,
                  RegistrationState* state) {
  CutEvent event;
  if (better.by == ModelChange::By::Regripped) {
    if (state->mesh.VertexCount() == better.fitted.positions.rows()) {
      state->grips =
          MovedOn(std::move(better.fitted), better.then->grips, state->grips, state->mesh.rest);
      state->grips.torn = false;  // no cut
    }
    return event;
  }
  event.cut = better.cut;
  event.point = better.instead.line.points.row(0).transpose();
  ModelCut& cut = state->cuts[better.cut];
  const ModelCut& before = better.then->cuts[better.cut];
  const Vec3 now = EndOf(cut, better.at_end), then = EndOf(before, better.at_end),
             tip = EndOf(better.instead, better.at_end);
  if (better.by == ModelChange::By::Longer) {
    // It may have grown there meanwhile, perhaps further, or elsewhere.
    const double on_mm = (tip - now).dot((tip - then).normalized());
    if (on_mm < kShortest_mm || (now != then && on_mm < kStraight * (tip - now).norm()))
      return event;
  }
  if (better.by == ModelChange::By::Shorter && now != then) return event;  // it goes on there
  for (const bool at_end : {false, true})
    if (!HasGrown(before, cut, at_end)) cut.too_far_mm[at_end] += better.shorter_mm[at_end];
  if (better.by != ModelChange::By::Turned)
    cut.line.points = WithGrowth(better.instead, before, cut);
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
