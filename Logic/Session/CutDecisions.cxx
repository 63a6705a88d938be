// Decisions about cuts: the part of RegistrationSession that a recorded study never uses.
#include <algorithm>

#include "Registration/CutDetection.h"
#include "Registration/ModelUpdate.h"
#include "Session/RegistrationSession.h"
#include "Session/StageClock.h"

namespace kerf {

ModelCut* RegistrationSession::Cut(int cut) {
  if (cut < 0 || cut >= static_cast<int>(state_.cuts.size())) return nullptr;
  return &state_.cuts[cut];
}

/// A decision changes the cuts: what is being searched for is out of date.
void RegistrationSession::DropSearch() {
  search_.Drop();
  state_.probing = {};
}

bool RegistrationSession::InModel(int cut) const {
  return std::any_of(applied_.begin(), applied_.end(),
                     [&](const Applied& a) { return a.cut == cut; });
}

/// The cuts that this step applied for the first time, with the model before them.
void RegistrationSession::NoteCuts(const StepReport& step) {
  for (const CutEvent& event : step.cuts) {
    if (!event.report.done || InModel(event.cut)) continue;
    applied_.push_back({event.cut, before_});
    decisions_.push_back({Decision::Kind::Taken, event.cut, {}, {}});
  }
}

CutReport RegistrationSession::ApplyNow(int cut) {
  Engine engine = MakeEngine();
  const bool kept = history_kept_ && !InModel(cut);
  if (kept) applied_.push_back({cut, state_});
  clock_->Start();
  const CutReport report = ApplyCut(state_.cuts[cut], options_, engine, &state_);
  clock_->Finish();
  if (kept && !report.done) applied_.pop_back();  // the cutter refused it
  return report;
}

/// The model without this cut: as it was before it, with all other cuts done again as far as they
/// have come.
bool RegistrationSession::TakeOut(int cut) {
  const auto found = std::find_if(applied_.begin(), applied_.end(),
                                  [&](const Applied& a) { return a.cut == cut; });
  if (found == applied_.end()) return false;
  Engine engine = MakeEngine();
  // From the model before any cut, where that can be done: S may have been turned meanwhile.
  if (state_.origin && state_.grips.positions.rows() >= state_.origin->mesh.VertexCount()) {
    std::vector<ModelCut> others = state_.cuts;
    for (std::size_t i = 0; i < others.size(); ++i)
      if (static_cast<int>(i) == cut || !InModel(static_cast<int>(i))) others[i].in_model = false;
    if (auto model = CutAnew(others, options_, state_, true)) {
      Adopt(std::move(*model), options_, engine, &state_);
      // The models before later cuts still hold this one: theirs is now the one before it.
      for (auto later = found + 1; later != applied_.end(); ++later) later->before = found->before;
      applied_.erase(found);
      return true;
    }
  }
  const auto then = found->before.cuts;
  const auto grew = [&](std::size_t earlier) {  // since the model was kept, or not yet there
    return earlier >= then.size() || !then[earlier].in_model ||
           then[earlier].surface.triangles.rows() != state_.cuts[earlier].surface.triangles.rows();
  };
  RestoreModel(found->before, options_, engine, &state_);
  std::vector<Applied> kept(applied_.begin(), found), later(found + 1, applied_.end());
  clock_->Start();
  std::vector<Applied> now;
  // Whether the model has this cut now; it may have been refused without the one taken out.
  const auto cut_again = [&](int again) {
    ModelCut& known = state_.cuts[again];
    ApplyCut(known, options_, engine, &state_);
    return known.in_model;
  };
  for (Applied& earlier : kept) {
    const std::size_t i = earlier.cut;
    ModelCut& known = state_.cuts[i];
    known.in_model = i < then.size() && then[i].in_model;
    known.partial = known.in_model && then[i].partial;
    if (!grew(i) || cut_again(earlier.cut)) now.push_back(std::move(earlier));
  }
  for (const Applied& again : later) {
    state_.cuts[again.cut].in_model = false;
    now.push_back({again.cut, state_});
    if (!cut_again(again.cut)) now.pop_back();
  }
  clock_->Finish();
  applied_ = std::move(now);
  return true;
}

CutReport RegistrationSession::AcceptCut(int cut) {
  CutReport report;
  report.reason = "no such proposal";
  ModelCut* proposal = Cut(cut);
  if (!proposal || !proposal->held) return report;
  DropSearch();
  const WholeOrBefore whole(&state_);
  proposal->held = false;
  decisions_.push_back({Decision::Kind::Accepted, cut, {}, {}});
  return ApplyNow(cut);
}

bool RegistrationSession::Reject(int cut, Decision* decision) {
  ModelCut* given = Cut(cut);
  if (!given || given->rejected || given->line.points.rows() == 0) return false;
  *decision = {Decision::Kind::Rejected, cut, *given, state_.evidence.refused_mm};
  if (!given->held && !history_kept_) return false;
  if (InModel(cut) && !TakeOut(cut)) return false;
  RefuseEvidence(given->line.points, &state_);
  ModelCut empty;
  empty.rejected = true;
  empty.drawn = given->drawn;
  empty.detected_frame = given->detected_frame;
  empty.confidence = given->confidence;
  empty.direction = given->direction;
  empty.view = given->view;
  *given = empty;
  return true;
}

bool RegistrationSession::RejectCut(int cut) {
  const WholeOrBefore whole(&state_);
  Decision decision;
  DropSearch();
  if (!Reject(cut, &decision)) return false;
  decisions_.push_back(std::move(decision));
  return true;
}

int RegistrationSession::DrawCut(const Points& line, const Vec3& direction, double depth_mm,
                                 CutReport* report) {
  if (line.rows() < 2 || !line.allFinite() || !(direction.norm() > 1e-9)) return -1;
  DropSearch();
  const WholeOrBefore whole(&state_);
  const Vec3 unit = direction.normalized();
  const double depth = depth_mm > 0 ? depth_mm : ThroughDepth_mm(state_.mesh, unit);
  state_.cuts.push_back(MakeDrawnCut(line, unit, depth, state_));
  const int cut = static_cast<int>(state_.cuts.size()) - 1;
  const CutReport done = ApplyNow(cut);
  if (report) *report = done;
  decisions_.push_back({Decision::Kind::Drawn, cut, {}, {}});
  return cut;
}

RegistrationSession::Undone RegistrationSession::Undo() {
  if (decisions_.empty()) return {};
  DropSearch();
  const WholeOrBefore whole(&state_);
  const Decision last = std::move(decisions_.back());
  decisions_.pop_back();
  const std::string name = "cut " + std::to_string(last.cut + 1);
  Undone undone;
  undone.cut = last.cut;
  Decision ignored;
  switch (last.kind) {
    case Decision::Kind::Taken:
      if (Reject(last.cut, &ignored)) undone.what = name + " taken out";
      break;
    case Decision::Kind::Drawn:
      if (Reject(last.cut, &ignored)) undone.what = "drawn " + name + " taken out";
      break;
    case Decision::Kind::Accepted: {
      ModelCut* cut = Cut(last.cut);
      if (!cut || cut->rejected || (InModel(last.cut) && !TakeOut(last.cut))) break;
      cut->held = true;
      cut->in_model = cut->partial = false;
      undone.what = name + " is a proposal again";
      break;
    }
    case Decision::Kind::Rejected:
      state_.cuts[last.cut] = last.was;
      state_.evidence.refused_mm = last.refused_mm;
      state_.cuts[last.cut].in_model = state_.cuts[last.cut].partial = false;
      if (!last.was.held) undone.again = ApplyNow(last.cut);
      undone.what = name + " is back";
      break;
  }
  return undone;
}

}  // namespace kerf
