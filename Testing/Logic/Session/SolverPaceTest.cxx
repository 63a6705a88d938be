// From time to a number of iterations, and back out of a journal.
#include <gtest/gtest.h>

#include "Core/Errors.h"
#include "CrackedBand.h"
#include "Session/IntraoperativeDecision.h"
#include "Session/SolverPace.h"

namespace kerf {
namespace {

TEST(SolverPace, NoLimitWhileThereIsTime) {
  SolverPace pace(40.0);
  for (int frame = 0; frame < 50; ++frame) pace.Note(15.0, 8.0, 40);
  EXPECT_EQ(pace.Limit(), 0);
  SolverPace none(0.0);
  for (int frame = 0; frame < 50; ++frame) none.Note(900.0, 800.0, 40);
  EXPECT_EQ(none.Limit(), 0);
}

TEST(SolverPace, LimitsToWhatFitsAndLetsGoAgain) {
  SolverPace pace(40.0);
  for (int frame = 0; frame < 50; ++frame) pace.Note(70.0, 60.0, 60);  // 10 ms and 1 ms each
  EXPECT_EQ(pace.Limit(), 0);  // 30 fit: as many as a frame ever takes
  for (int frame = 0; frame < 50; ++frame) pace.Note(90.0, 80.0, 40);  // 10 ms and 2 ms each
  EXPECT_GE(pace.Limit(), 12);
  EXPECT_LE(pace.Limit(), 19);
  for (int frame = 0; frame < 50; ++frame) pace.Note(300.0, 290.0, 30);
  EXPECT_EQ(pace.Limit(), 12);  // the fewest: a slow motion is still followed
  for (int frame = 0; frame < 50; ++frame) pace.Note(12.0, 2.0, 20);
  EXPECT_EQ(pace.Limit(), 0);
}

TEST(SolverPace, SmallChangesOfSpeedDoNotFillTheJournal) {
  SolverPace pace(40.0);
  int changes = 0, before = 0;
  for (int frame = 0; frame < 300; ++frame) {
    pace.Note(130.0 + frame % 7, 120.0 + frame % 7, 60);
    changes += pace.Limit() != before;
    before = pace.Limit();
  }
  EXPECT_GE(changes, 1);
  EXPECT_LE(changes, 4);
}

TEST(SolverPace, TheLimitComesOutOfTheJournalAsItWentIn) {
  IntraoperativeDecision decision;
  decision.kind = IntraoperativeDecision::Kind::LimitSolver;
  decision.iterations = 17;
  JournalEntry entry;
  entry.event = EventName(decision.kind);
  EXPECT_THROW(DecisionOf(entry, "journal"), InputError);
  const JournalData data = ToJournal(decision);
  ASSERT_EQ(data.size(), 1u);
  EXPECT_EQ(data[0].first, "iterations");
  EXPECT_EQ(std::get<std::int64_t>(data[0].second.value), 17);
  testing::BandRun run(true, false);
  Decide(run.session.get(), &decision);
  EXPECT_EQ(run.session->Options().solve.most_iterations, 17);
  decision.iterations = 0;
  Decide(run.session.get(), &decision);
  EXPECT_EQ(run.session->Options().solve.most_iterations, kFrameIterations);
}

}  // namespace
}  // namespace kerf
