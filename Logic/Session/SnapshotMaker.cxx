#include "Session/SnapshotMaker.h"

#include <algorithm>

#include "Geometry/EmbedPoints.h"
#include "Registration/CutLine.h"

namespace kerf {
namespace {

double Length_mm(const Points& line) {
  double sum = 0.0;
  for (Index i = 0; i + 1 < line.rows(); ++i) sum += (line.row(i + 1) - line.row(i)).norm();
  return sum;
}

bool InModel(const ModelCut& cut) { return cut.in_model && !cut.held && !cut.rejected; }

}  // namespace

SnapshotMaker::SnapshotMaker(const SurfaceMesh& uncut, PlannedCut plan)
    : uncut_(uncut), plan_(std::move(plan)), view_(uncut_) {
  if (!plan_.sheet.Empty()) sheet_.emplace(plan_.sheet);
}

void SnapshotMaker::Lines(const RegistrationState& state, IntraoperativeSnapshot* out) {
  cut_view_.Update(state, &out->organ_cut_face);
  out->margin_mm = cut_view_.TumourMargin_mm();
  std::string of = std::to_string(state.mesh.TetCount());
  for (const ModelCut& cut : state.cuts)
    of += (cut.held ? " h" : " ") + std::to_string(cut.line.points.rows());
  if (bound_.of != of) {
    bound_ = {of, {}, {}, {}};
    for (const Points& line : plan_.lines) bound_.planned.push_back(EmbedPoints(state.mesh, line));
    for (const ModelCut& cut : state.cuts) {
      if (!cut.held) continue;
      const Points line = LineOnSurface(cut.line, cut.view, uncut_);
      if (line.rows() > 1) bound_.proposed.push_back(EmbedPoints(state.mesh, line));
    }
    if (sheet_) bound_.deviation = MeasurePlanDeviation(view_.Update(state), *sheet_);
  }
  out->deviation = bound_.deviation;
  out->planned_margin_mm = plan_.margin_mm;
  const auto now = [&](const Embedding& line) {
    return line.Positions(state.positions, state.mesh.tets);
  };
  for (const Embedding& line : bound_.planned) out->planned_lines.push_back(now(line));
  for (const Embedding& line : bound_.proposed) out->proposed_lines.push_back(now(line));
  const auto& lips = cut_view_.Lips();
  const auto& lip_cuts = cut_view_.LipCuts();
  for (std::size_t i = 0; i < lips.size(); ++i)
    if (!state.cuts[lip_cuts[i]].held) out->applied_lines.push_back(lips[i]);
}

std::shared_ptr<const IntraoperativeSnapshot> SnapshotMaker::LastWithout(std::size_t cut) const {
  for (const auto& candidate : {trusted_, previous_})
    if (candidate &&
        (cut >= candidate->cuts.size() || candidate->cuts[cut].state != CutItem::State::Applied))
      return candidate;
  return nullptr;
}

std::shared_ptr<const IntraoperativeSnapshot> SnapshotMaker::Valid(
    std::shared_ptr<const IntraoperativeSnapshot> before, const RegistrationState& state) const {
  const auto taken_out = [&](const CutItem& cut) {
    return cut.state == CutItem::State::Applied && !InModel(state.cuts[cut.number]);
  };
  while (before) {
    const auto& cuts = before->cuts;
    const auto stale = std::find_if(cuts.begin(), cuts.end(), taken_out);
    if (stale == cuts.end()) break;
    before = stale->before;
  }
  return before;
}

void SnapshotMaker::Cuts(const SessionFrame& report, const RegistrationState& state,
                         IntraoperativeSnapshot* out) {
  for (std::size_t i = 0; i < state.cuts.size(); ++i) {
    const ModelCut& cut = state.cuts[i];
    if (i == known_.size()) known_.push_back({report.time_s, false, nullptr});
    Known& known = known_[i];
    const bool in_model = InModel(cut);
    if (in_model && !known.in_model) known.before = LastWithout(i);
    if (!in_model) known.before.reset();
    known.in_model = in_model;
    CutItem item;
    item.number = static_cast<int>(i);
    item.state = cut.rejected ? CutItem::State::Rejected
                 : cut.held   ? CutItem::State::Proposed
                              : CutItem::State::Applied;
    item.frame = cut.detected_frame;
    item.time_s = known.time_s;
    item.confidence = cut.confidence;
    item.length_mm = Length_mm(cut.line.points);
    item.drawn = cut.drawn;
    item.partial = in_model && cut.partial;
    item.before = Valid(known.before, state);
    out->cuts.push_back(item);
  }
}

std::shared_ptr<IntraoperativeSnapshot> SnapshotMaker::Make(const Frame& frame,
                                                            const SessionFrame& report,
                                                            const RegistrationState& state) {
  auto out = std::make_shared<IntraoperativeSnapshot>();
  out->frame = frame;
  const OrganView& organ = view_.Update(state);
  out->organ = organ.current;
  out->organ_cut_face = organ.cut_face;
  for (const Structure& structure : state.structures)
    if (!structure.rest.Empty())
      out->structures.push_back({structure.name, CurrentSurface(structure, state)});
  Lines(state, out.get());
  Cuts(report, state, out.get());
  out->reliability = report.reliability;
  out->gate = report.reliability.state;
  out->reason = report.reliability.reason;
  out->times = report.times;
  out->tetrahedra = state.mesh.TetCount();
  if (out->gate != GateState::Off) trusted_ = out;
  previous_ = out;
  return out;
}

}  // namespace kerf
