// Accept, reject, undo and draw: what a surgeon decides about cuts, and that it can be repeated.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <thread>
#include <utility>

#include "CrackedBand.h"
#include "Session/IntraoperativeDecision.h"

namespace kerf {
namespace {

using namespace testing;

TEST(CutDecisions, WhatWasNotCutIsSaid) {
  CutReport report;
  report.reason = "for a reason";
  EXPECT_EQ(TextOf(report), "but not cut: for a reason");
  report.done = report.partial = true;
  EXPECT_EQ(TextOf(report), "the model is cut, but not along the whole cut: for a reason.");
  report = {};
  report.done = true;
  EXPECT_EQ(TextOf(report), "the model is cut.");
}

TEST(CutDecisions, HistoryChangesNoBit) {
  BandRun plain(false), kept(true);
  plain.RunTo(60);
  kept.RunTo(60);
  ASSERT_FALSE(plain.State().cuts.empty());
  EXPECT_TRUE(plain.State().positions == kept.State().positions);
  EXPECT_TRUE(plain.State().mesh.tets == kept.State().mesh.tets);
}

TEST(CutDecisions, ARejectedCutLeavesTheModelAndDoesNotComeBackAtOnce) {
  BandRun run(true, false, 55);
  const Index before = BandMesh(3000).TetCount();
  ASSERT_TRUE(run.RunToCut());
  ASSERT_EQ(run.State().cuts.size(), 1u);
  EXPECT_GT(run.State().mesh.TetCount(), before);
  run.RunTo(56);
  ASSERT_TRUE(run.session->RejectCut(0));
  EXPECT_EQ(run.State().mesh.TetCount(), before);
  EXPECT_TRUE(run.State().cuts[0].rejected);
  for (int i = 0; i < 20; ++i) EXPECT_TRUE(run.Next().step.cuts.empty()) << "frame " << run.next;
  EXPECT_EQ(run.State().mesh.TetCount(), before);
  EXPECT_LT(run.Next().reliability.residual_px, 6.0);  // the model has not stayed behind
  EXPECT_FALSE(run.session->RejectCut(0));             // twice is once
}

TEST(CutDecisions, ACutThatOpensOnAndOnIsProposedAgain) {
  BandRun run;
  ASSERT_TRUE(run.RunToCut());
  ASSERT_TRUE(run.session->RejectCut(0));
  bool again = false;
  while (run.next < kRestFrames + kCutFrames) again = !run.Next().step.cuts.empty() || again;
  EXPECT_TRUE(again);
}

TEST(CutDecisions, AProposalWaitsIsAcceptedAndUndone) {
  BandRun run(true, true);
  const Index before = BandMesh(3000).TetCount();
  ASSERT_TRUE(run.RunToCut());
  EXPECT_TRUE(run.State().cuts[0].held);
  run.RunTo(kRestFrames + kCutFrames);
  EXPECT_EQ(run.State().mesh.TetCount(), before);
  const CutReport report = run.session->AcceptCut(0);
  EXPECT_TRUE(report.done) << report.reason;
  EXPECT_GT(run.State().mesh.TetCount(), before);
  EXPECT_FALSE(run.State().cuts[0].held);
  run.Next();
  EXPECT_EQ(run.session->Undo().what, "cut 1 is a proposal again");
  EXPECT_EQ(run.State().mesh.TetCount(), before);
  EXPECT_TRUE(run.State().cuts[0].held);
  EXPECT_EQ(run.session->Undo().what, "");
}

TEST(CutDecisions, ARejectedProposalComesBackByUndo) {
  BandRun run(true, true, 55);
  ASSERT_TRUE(run.RunToCut());
  run.RunTo(56);
  const Points line = run.State().cuts[0].line.points;
  ASSERT_TRUE(run.session->RejectCut(0));
  for (int i = 0; i < 5; ++i) EXPECT_TRUE(run.Next().step.cuts.empty());
  EXPECT_EQ(run.session->Undo().what, "cut 1 is back");
  EXPECT_TRUE(run.State().cuts[0].line.points == line);
  EXPECT_TRUE(run.State().cuts[0].held);
}

TEST(CutDecisions, WhatBecameOfACutThatUndoBringsBackIsSaidAndWritten) {
  BandRun run;
  run.RunTo(3);
  const auto decide = [&](IntraoperativeDecision::Kind kind, int cut, const Points& line) {
    IntraoperativeDecision decision;
    decision.kind = kind;
    decision.cut = cut;
    decision.line = line;
    decision.direction = Vec3(0, 0, -1);
    const DecisionOutcome outcome = Decide(run.session.get(), &decision);
    return std::pair(outcome, JournalLines(decision, outcome, run.State()));
  };
  using Kind = IntraoperativeDecision::Kind;
  const Points through = AcrossBand(-30), beside = AcrossBand(200);
  for (const bool meets : {true, false}) {
    const auto [drawn, drawn_lines] = decide(Kind::DrawCut, -1, meets ? through : beside);
    ASSERT_TRUE(drawn.done && drawn.cut);
    EXPECT_EQ(drawn.cut->done, meets) << drawn.words;
    ASSERT_EQ(drawn_lines.size(), 2u);
    EXPECT_EQ(drawn_lines[1].first, meets ? "cut applied" : "cut refused");
    const int cut = meets ? 0 : 1;
    const auto [rejected, rejected_lines] = decide(Kind::RejectCut, cut, {});
    ASSERT_TRUE(rejected.done);
    EXPECT_EQ(rejected_lines.size(), 1u);
    const auto [back, back_lines] = decide(Kind::Undo, -1, {});
    ASSERT_TRUE(back.done && back.cut) << back.words;
    EXPECT_EQ(back.words, meets ? "Undone: cut 1 is back: the model is cut."
                                : "Undone: cut 2 is back, " + TextOf(*back.cut));
    ASSERT_EQ(back_lines.size(), 2u);
    EXPECT_EQ(back_lines[0].first, "undone");
    EXPECT_EQ(back_lines[1].first, drawn_lines[1].first);
    EXPECT_EQ(run.State().cuts[cut].in_model, meets);
  }
}

TEST(CutDecisions, UndoTakesAnAutomaticCutOut) {
  BandRun run;
  const Index before = BandMesh(3000).TetCount();
  ASSERT_TRUE(run.RunToCut());
  EXPECT_EQ(run.session->Undo().what, "cut 1 taken out");
  EXPECT_EQ(run.State().mesh.TetCount(), before);
}

TEST(CutDecisions, OneOfTwoDrawnCutsIsTakenOut) {
  BandRun run;
  run.RunTo(3);
  const Vec3 down(0, 0, -1);
  CutReport report;
  EXPECT_EQ(run.session->DrawCut(AcrossBand(-30), down, 0, &report), 0);
  EXPECT_TRUE(report.done) << report.reason;
  EXPECT_EQ(run.session->DrawCut(AcrossBand(30), down, 0, &report), 1);
  EXPECT_TRUE(report.done) << report.reason;
  EXPECT_EQ(MeasureQuality(run.State().mesh, run.State().mesh.rest).components, 3);
  run.Next();
  ASSERT_TRUE(run.session->RejectCut(0));
  const MeshQuality two = MeasureQuality(run.State().mesh, run.State().mesh.rest);
  EXPECT_EQ(two.components, 2);
  EXPECT_TRUE(two.manifold_boundary);
  run.Next();
  EXPECT_TRUE(run.State().positions.allFinite());
  EXPECT_EQ(run.session->Undo().what, "cut 1 is back");
  EXPECT_EQ(MeasureQuality(run.State().mesh, run.State().mesh.rest).components, 3);
}

TEST(CutDecisions, ThreeCutsAreTakenOutInAnyOrderAndComeBack) {
  const auto pieces = [](const BandRun& run) {
    return MeasureQuality(run.State().mesh, run.State().mesh.rest).components;
  };
  // Without grips there is no cutting anew: the model before the cut serves, and later ones again.
  for (const bool grips : {true, false})
    for (const std::array<int, 2>& order : {std::array{0, 1}, {1, 0}, {2, 0}, {0, 2}}) {
      BandRun run(true, false, 1 << 20, 1 << 20, grips);
      run.RunTo(3);
      for (const double x : {-30.0, 0.0, 30.0})
        ASSERT_GE(run.session->DrawCut(AcrossBand(x), Vec3(0, 0, -1), 0, nullptr), 0);
      ASSERT_EQ(pieces(run), 4);
      int left = 3;
      for (const int cut : order) {
        ASSERT_TRUE(run.session->RejectCut(cut));
        EXPECT_EQ(pieces(run), left--);
        const auto& cuts = run.State().cuts;
        EXPECT_EQ(std::count_if(cuts.begin(), cuts.end(),
                                [](const ModelCut& cut) { return cut.in_model; }),
                  left);
        run.Next();
        EXPECT_TRUE(run.State().positions.allFinite());
      }
      for (int there = 3; there < 5; ++there) {
        EXPECT_NE(run.session->Undo().what, "");
        EXPECT_EQ(pieces(run), there);
      }
    }
}

TEST(CutDecisions, AnEndThatIsLedOverTheRimIsSaid) {
  BandRun run;
  run.RunTo(3);
  const auto draw = [&](double x, double from_y, double to_y) {
    IntraoperativeDecision decision;
    decision.kind = IntraoperativeDecision::Kind::DrawCut;
    decision.line.resize(9, 3);
    for (int i = 0; i < 9; ++i) decision.line.row(i) << x, from_y + (to_y - from_y) * i / 8, 5.0;
    decision.direction = Vec3(0, 0, -1);
    const DecisionOutcome outcome = Decide(run.session.get(), &decision);
    EXPECT_TRUE(outcome.done);
    return outcome.words;
  };
  EXPECT_EQ(draw(-30, -8, 8), "Cut 1 drawn: the model is cut.");
  const std::string led = draw(0, -8, 18.5);  // the rim is at 20
  EXPECT_NE(led.find("One end was led over the organ's rim"), std::string::npos) << led;
  const std::string both = draw(30, -18.5, 18.5);
  EXPECT_NE(both.find("Both ends"), std::string::npos) << both;
}

TEST(CutDecisions, ADrawnEndIsBelievedToAFeatureSpacing) {
  const auto end_y = [](double drawn_to_y) {
    BandRun run(true, true);
    run.RunTo(3);
    Points line = AcrossBand(kCrackX_mm);
    for (Index i = 0; i < line.rows(); ++i)
      line(i, 1) = -25.0 + (drawn_to_y + 25.0) * double(i) / double(line.rows() - 1);
    EXPECT_EQ(run.session->DrawCut(line, Vec3(0, 0, -1), 0, nullptr), 0);
    run.RunTo(kRestFrames + kCutFrames + 10);
    const Points& now = run.State().cuts[0].line.points;
    return now(now.rows() - 1, 1);
  };
  // The crack ends at y = 5, its features lie 4 to 5 mm apart.
  EXPECT_NEAR(end_y(1.0), 1.0, 1e-9);
  const double cut_on = end_y(-10.0);
  EXPECT_GT(cut_on, -1.0);
  EXPECT_LT(cut_on, 5.0);
}

TEST(CutDecisions, AStrokeOverTheImageIsALineAtRest) {
  BandRun run;
  run.RunTo(20);
  Pixels stroke(9, 2);  // from above the band to below it at x = 10 mm
  const CameraModel camera = BandCamera();
  for (int i = 0; i < 9; ++i)
    stroke.row(i) = camera.Project(CrackMotion(Vec3(10, -26 + 6.5 * i, 5), 19)).transpose();
  const Points line = RestLineOfStroke(stroke, camera, run.State());
  ASSERT_EQ(line.rows(), 9);
  for (Index i = 0; i < 9; ++i) EXPECT_NEAR(line(i, 0), 10.0, 1.0) << i;
  EXPECT_LT(line(0, 1), -20.0);
  EXPECT_GT(line(8, 1), 20.0);
  EXPECT_EQ(RestLineOfStroke(Pixels::Zero(3, 2), camera, run.State()).rows(), 0);
}

TEST(CutDecisions, TheJournalRepeatsThemBitByBit) {
  BandRun live(true, true);
  std::vector<std::pair<int, JournalEntry>> journal;
  const auto decide = [&](IntraoperativeDecision decision) {
    ASSERT_TRUE(Decide(live.session.get(), &decision).done);
    JournalEntry entry;
    entry.frame = live.next;
    entry.event = EventName(decision.kind);
    entry.data = ToJournal(decision);
    journal.push_back({live.next, entry});
  };
  ASSERT_TRUE(live.RunToCut());
  IntraoperativeDecision accept, draw, undo;
  accept.kind = IntraoperativeDecision::Kind::AcceptCut;
  accept.cut = 0;
  decide(accept);
  live.RunTo(live.next + 3);
  draw.kind = IntraoperativeDecision::Kind::DrawCut;
  draw.stroke.resize(2, 2);
  draw.stroke << 330, 160, 330, 380;
  decide(draw);
  live.RunTo(live.next + 2);
  undo.kind = IntraoperativeDecision::Kind::Undo;
  decide(undo);
  live.RunTo(live.next + 3);

  BandRun again(true, true);
  std::size_t next = 0;
  while (again.next < live.next) {
    for (; next < journal.size() && journal[next].first <= again.next; ++next) {
      auto decision = DecisionOf(journal[next].second, "journal.jsonl");
      ASSERT_TRUE(decision);
      Decide(again.session.get(), &*decision);
    }
    again.Next();
  }
  EXPECT_TRUE(live.State().positions == again.State().positions);
  EXPECT_TRUE(live.State().mesh.tets == again.State().mesh.tets);
}

TEST(CutDecisions, NonsenseChangesNothing) {
  BandRun run;
  run.RunTo(2);
  EXPECT_FALSE(run.session->RejectCut(0));
  EXPECT_FALSE(run.session->AcceptCut(-3).done);
  EXPECT_EQ(run.session->DrawCut(Points(1, 3), Vec3::UnitZ(), 0, nullptr), -1);
  EXPECT_EQ(run.session->DrawCut(AcrossBand(0), Vec3::Zero(), 0, nullptr), -1);
  EXPECT_EQ(run.session->Undo().what, "");
}

/// Runs to the frame in which a search is to be taken over. @return false where there is none
bool RunToDueSearch(BandRun* run) {
  while (run->next < kRestFrames + kCutFrames + 40) {
    if (run->State().probing.due_frame == run->next) return true;
    run->Next();
  }
  return false;
}

TEST(Search, IsTakenOverWhenItIsSaidHoweverLongItTook) {
  // As in a live session, slow and late, and in a replay of it: as late without being slow.
  std::vector<Points> places;
  for (const auto how_long : {std::chrono::milliseconds(0), std::chrono::milliseconds(30)}) {
    BandRun run(true, false);
    ASSERT_TRUE(RunToDueSearch(&run));
    const int due = run.State().probing.due_frame;
    IntraoperativeDecision decision;
    decision.kind = IntraoperativeDecision::Kind::HoldSearch;
    EXPECT_TRUE(Decide(run.session.get(), &decision).done);
    for (int frame = 0; frame < 5; ++frame) {
      std::this_thread::sleep_for(how_long);
      run.Next();
      EXPECT_EQ(run.State().probing.due_frame, due) << "it was taken over";
    }
    decision.kind = IntraoperativeDecision::Kind::TakeSearch;
    EXPECT_TRUE(Decide(run.session.get(), &decision).done);
    EXPECT_TRUE(decision.cut == -1 && ToJournal(decision).empty());
    run.Next();
    EXPECT_NE(run.State().probing.due_frame, due) << "it was not taken over";
    run.RunTo(run.next + 5);
    places.push_back(run.State().positions);
  }
  ASSERT_EQ(places[0].rows(), places[1].rows());
  EXPECT_TRUE(places[0] == places[1]);
}

TEST(Search, WhatTheClockDecidesComesOutOfTheJournalAsItWentIn) {
  for (const auto kind :
       {IntraoperativeDecision::Kind::HoldSearch, IntraoperativeDecision::Kind::TakeSearch}) {
    JournalEntry entry;
    entry.event = EventName(kind);
    const auto decision = DecisionOf(entry, "journal");
    ASSERT_TRUE(decision);
    EXPECT_EQ(decision->kind, kind);
  }
}

}  // namespace
}  // namespace kerf
