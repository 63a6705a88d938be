#include "Session/IntraoperativeDecision.h"

#include "Core/Errors.h"
#include "Session/RegistrationSession.h"

namespace kerf {
namespace {

using Kind = IntraoperativeDecision::Kind;
constexpr Kind kKinds[] = {Kind::AcceptCut,  Kind::RejectCut, Kind::Undo,    Kind::DrawCut,
                           Kind::HoldCuts,   Kind::TakeCuts,  Kind::Confirm, Kind::LimitSolver,
                           Kind::HoldSearch, Kind::TakeSearch};

/// Ends of a drawn line that were led over the rim, in words; empty where it stayed as it was.
std::string LedOverRim(const Points& drawn, const Points& made) {
  constexpr double kMoved_mm = 0.1;
  if (made.rows() < 2) return {};
  const int ends = ((made.row(0) - drawn.row(0)).norm() > kMoved_mm) +
                   ((made.row(made.rows() - 1) - drawn.row(drawn.rows() - 1)).norm() > kMoved_mm);
  if (ends == 0) return {};
  return ends == 1 ? " One end was led over the organ's rim, which was near."
                   : " Both ends were led over the organ's rim, which was near.";
}

/// "Cut 1 accepted: the model is cut."
std::string WithReport(const std::string& what, const CutReport& report) {
  return what + (report.done ? ": " : ", ") + TextOf(report);
}

std::vector<double> Flat(const Points& points) {
  return {points.data(), points.data() + points.size()};
}

}  // namespace

const char* EventName(Kind kind) {
  switch (kind) {
    case Kind::AcceptCut:
      return "cut accepted";
    case Kind::RejectCut:
      return "cut rejected";
    case Kind::Undo:
      return "undone";
    case Kind::DrawCut:
      return "cut drawn";
    case Kind::HoldCuts:
      return "cuts wait";
    case Kind::TakeCuts:
      return "cuts automatic";
    case Kind::Confirm:
      return "registration confirmed";
    case Kind::LimitSolver:
      return "solver limited";
    case Kind::HoldSearch:
      return "search late";
    case Kind::TakeSearch:
      return "search ready";
  }
  return "";
}

JournalData ToJournal(const IntraoperativeDecision& decision) {
  JournalData data;
  if (decision.kind == Kind::AcceptCut || decision.kind == Kind::RejectCut)
    data.push_back({"cut", decision.cut});
  if (decision.kind == Kind::LimitSolver) data.push_back({"iterations", decision.iterations});
  if (decision.kind == Kind::DrawCut) {
    data.push_back({"line_rest_mm", Flat(decision.line)});
    data.push_back({"direction", std::vector<double>{decision.direction.x(), decision.direction.y(),
                                                     decision.direction.z()}});
    data.push_back({"depth_mm", decision.depth_mm});
  }
  return data;
}

std::optional<IntraoperativeDecision> DecisionOf(const JournalEntry& entry,
                                                 const std::string& file) {
  for (const Kind kind : kKinds) {
    if (entry.event != EventName(kind)) continue;
    IntraoperativeDecision decision;
    decision.kind = kind;
    const std::string where =
        "event \"" + entry.event + "\" before frame " + std::to_string(entry.frame);
    if (kind == Kind::AcceptCut || kind == Kind::RejectCut) {
      const auto cut = entry.Number("cut");
      if (!cut) throw InputError(file, where, "has no number of a cut");
      decision.cut = static_cast<int>(*cut);
    }
    if (kind == Kind::LimitSolver) {
      const auto iterations = entry.Number("iterations");
      if (!iterations || !(*iterations >= 0 && *iterations < 1e6))
        throw InputError(file, where, "has no number of iterations");
      decision.iterations = static_cast<int>(*iterations);
    }
    if (kind == Kind::DrawCut) {
      const auto line = entry.Numbers("line_rest_mm"), direction = entry.Numbers("direction");
      if (line.size() < 6 || line.size() % 3 != 0 || direction.size() != 3)
        throw InputError(file, where, "has no line or no direction");
      decision.line = Eigen::Map<const Points>(line.data(), line.size() / 3, 3);
      decision.direction = Vec3(direction[0], direction[1], direction[2]);
      decision.depth_mm = entry.Number("depth_mm").value_or(0.0);
    }
    return decision;
  }
  return std::nullopt;
}

std::string TextOf(const CutReport& report) {
  if (!report.done) return "but not cut: " + report.reason;
  return report.partial ? "the model is cut, but not along the whole cut: " + report.reason + "."
                        : "the model is cut.";
}

const char* EventName(const CutReport& report) {
  return report.done ? "cut applied" : "cut refused";
}

JournalData ToJournal(int cut, const Vec3& point_rest_mm, const CutReport& report) {
  return {{"cut", cut},
          {"point_rest_mm",
           std::vector<double>{point_rest_mm.x(), point_rest_mm.y(), point_rest_mm.z()}},
          {"partial", report.partial},
          {"reason", report.reason},
          {"new_vertices", int(report.new_vertices)},
          {"new_tetrahedra", int(report.new_tets)},
          {"components", report.components},
          {"smallest_dihedral_deg", report.smallest_dihedral_deg}};
}

DecisionOutcome Decide(RegistrationSession* session, IntraoperativeDecision* decision) {
  const std::string name = "Cut " + std::to_string(decision->cut + 1);
  switch (decision->kind) {
    case Kind::AcceptCut: {
      const CutReport report = session->AcceptCut(decision->cut);
      if (!report.done && report.reason == "no such proposal")
        return {false, name + " is no proposal that waits."};
      return {true, WithReport(name + " accepted", report), report};
    }
    case Kind::RejectCut:
      if (!session->RejectCut(decision->cut)) return {false, name + " cannot be rejected."};
      return {true, name + " rejected."};
    case Kind::Undo: {
      const RegistrationSession::Undone undone = session->Undo();
      if (undone.what.empty()) return {false, "There is nothing to undo."};
      const std::string words = "Undone: " + undone.what;
      if (!undone.again) return {true, words + "."};
      decision->cut = undone.cut;
      return {true, WithReport(words, *undone.again), undone.again};
    }
    case Kind::DrawCut: {
      if (decision->line.rows() == 0)
        decision->line = RestLineOfStroke(decision->stroke, session->Camera(), session->State());
      if (decision->direction.isZero()) decision->direction = session->Camera().ViewDirection();
      CutReport report;
      decision->cut =
          session->DrawCut(decision->line, decision->direction, decision->depth_mm, &report);
      if (decision->cut < 0) return {false, "The stroke does not meet the organ: nothing is cut."};
      std::string drawn = WithReport("Cut " + std::to_string(decision->cut + 1) + " drawn", report);
      if (report.done)
        drawn += LedOverRim(decision->line, session->State().cuts[decision->cut].line.points);
      return {true, drawn, report};
    }
    case Kind::HoldCuts:
      session->HoldCuts(true);
      return {true, "Cuts wait to be accepted."};
    case Kind::TakeCuts:
      session->HoldCuts(false);
      return {true, "Cuts are taken automatically."};
    case Kind::Confirm:
      return {true, "Registration confirmed."};
    case Kind::LimitSolver:
      session->LimitSolver(decision->iterations);
      return {true, {}};
    case Kind::HoldSearch:
      session->HoldSearch(true);
      return {true, {}};
    case Kind::TakeSearch:
      session->HoldSearch(false);
      return {true, {}};
  }
  return {};
}

std::vector<std::pair<std::string, JournalData>> JournalLines(
    const IntraoperativeDecision& decision, const DecisionOutcome& outcome,
    const RegistrationState& state) {
  std::vector<std::pair<std::string, JournalData>> lines{
      {EventName(decision.kind), ToJournal(decision)}};
  if (outcome.cut) {
    const Vec3 begin = state.cuts[decision.cut].line.points.row(0).transpose();
    lines.push_back({EventName(*outcome.cut), ToJournal(decision.cut, begin, *outcome.cut)});
  }
  return lines;
}

}  // namespace kerf
