#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "CaseIO/JournalRead.h"
#include "Core/Types.h"
#include "Cutting/TetCutter.h"

namespace kerf {

class RegistrationSession;
struct RegistrationState;

/// What the surgeon (or, for the solver's limit and the search for better cuts, the clock) decides
/// while a session runs. It takes effect between two frames and is written to the journal with the
/// number of the frame that it comes before, so that a replay does the same.
struct IntraoperativeDecision {
  enum class Kind {
    AcceptCut,
    RejectCut,
    Undo,
    DrawCut,
    HoldCuts,     ///< from now on proposals wait
    TakeCuts,     ///< from now on cuts are taken automatically
    Confirm,      ///< the registration is right again after a loss: show the overlay
    LimitSolver,  ///< from now on at most `iterations` a frame
    HoldSearch,   ///< the search for better cuts is late: frames do not wait for it
    TakeSearch    ///< what it found is taken over
  } kind = Kind::Undo;
  int cut = -1;
  Pixels stroke;                  ///< DrawCut, live: raw distorted px
  Points line;                    ///< DrawCut: at rest, LPS, mm; found from the stroke where empty
  Vec3 direction = Vec3::Zero();  ///< DrawCut; zero: the camera's
  double depth_mm = 0.0;          ///< DrawCut; 0: through
  int iterations = 0;             ///< LimitSolver; 0: as many as a frame ever takes
};

/// Event in the journal where registering threw: the frame that it names was not registered.
inline constexpr char kRegistrationStopped[] = "registration stopped";

/// Name of the event in the journal ("cut accepted").
const char* EventName(IntraoperativeDecision::Kind kind);
JournalData ToJournal(const IntraoperativeDecision& decision);
/// None where the entry is no decision. @throws InputError naming `file` where it is a broken one
std::optional<IntraoperativeDecision> DecisionOf(const JournalEntry& entry,
                                                 const std::string& file);

/// What became of a cut, as the end of a sentence.
std::string TextOf(const CutReport& report);

/// Event and data in the journal for what became of a cut. @param point_rest_mm where it begins
const char* EventName(const CutReport& report);
JournalData ToJournal(int cut, const Vec3& point_rest_mm, const CutReport& report);

/// Carries a decision out. Fills line, direction and depth of a drawn cut, so that what is written
/// to the journal can be repeated, and the number of a cut that undo brings back. @return what
/// happened, in words; `done` false: nothing changed
struct DecisionOutcome {
  bool done = false;
  std::string words;
  std::optional<CutReport> cut{};  ///< of a cut that was accepted, drawn or brought back by undo
};
DecisionOutcome Decide(RegistrationSession* session, IntraoperativeDecision* decision);

/// Events and data in the journal for a decision that was carried out: itself, then what became of
/// its cut. @param state after the decision
std::vector<std::pair<std::string, JournalData>> JournalLines(
    const IntraoperativeDecision& decision, const DecisionOutcome& outcome,
    const RegistrationState& state);

}  // namespace kerf
