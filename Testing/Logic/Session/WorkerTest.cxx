// The worker: snapshots out, decisions in, a recording that may fail.
#include <gtest/gtest.h>

#include "WorkerScene.h"

namespace kerf {
namespace {

using namespace testing;

TEST(Worker, AProposalIsAcceptedRejectedAndUndone) {
  Scene scene(true);
  ASSERT_TRUE(scene.Sees(20, [](const auto& s) {
    return !s.cuts.empty() && s.cuts[0].state == CutItem::State::Proposed;
  }));
  EXPECT_FALSE(scene.worker->Latest()->proposed_lines.empty());
  EXPECT_TRUE(scene.worker->Latest()->applied_lines.empty());
  const int before = scene.worker->Latest()->tetrahedra;
  scene.Post(Kind::AcceptCut, 0);
  ASSERT_TRUE(scene.Sees(5, [&](const auto& s) {
    return s.cuts[0].state == CutItem::State::Applied && s.tetrahedra > before;
  }));
  EXPECT_FALSE(scene.worker->Latest()->applied_lines.empty());
  scene.Post(Kind::RejectCut, 0);
  ASSERT_TRUE(scene.Sees(5, [&](const auto& s) {
    return s.cuts[0].state == CutItem::State::Rejected && s.tetrahedra == before;
  }));
  scene.Post(Kind::Undo);
  ASSERT_TRUE(scene.Sees(5, [&](const auto& s) {
    return s.cuts[0].state == CutItem::State::Applied && s.tetrahedra > before;
  }));
  EXPECT_EQ(scene.worker->Latest()->said, "Undone: cut 1 is back: the model is cut.");
  scene.worker->Stop();
  EXPECT_TRUE(scene.log->finished);
  for (const char* event : {"cut accepted", "cut rejected", "undone"})
    EXPECT_TRUE(scene.log->Has(event)) << event;
  for (std::size_t i = 0; i < scene.log->frames.size(); ++i)
    ASSERT_EQ(scene.log->frames[i], int(i));
}

TEST(Worker, AFullDiskIsSaidWhileTheSourceIsGone) {
  Scene scene(false);
  ASSERT_TRUE(scene.Sees(10, [](const auto& s) { return s.gate == GateState::Green; }));
  scene.log->full = true;
  *scene.hang = true;
  ASSERT_TRUE(scene.Sees(10, [](const auto& s) { return !s.source.Usable(); }));
  EXPECT_TRUE(
      scene.Sees(10, [](const auto& s) { return !s.recording_problem.empty() && !s.recording; }));
}

TEST(Worker, AFullDiskIsSaidAfterTheRegistrationHasStopped) {
  Scene scene(false, 1 << 20, 20);
  ASSERT_TRUE(scene.Sees(10, [](const auto& s) { return !s.stopped.empty(); }));
  scene.PicturesEnd();
  ASSERT_TRUE(scene.worker->Latest()->recording_problem.empty());
  scene.log->full = true;
  scene.worker->Note("mark", {});
  EXPECT_TRUE(scene.Sees(10, [](const auto& s) { return !s.recording_problem.empty(); }));
}

TEST(Worker, WhatIsNotedDuringTheLastFrameIsInTheJournal) {
  Scene scene(false);
  ASSERT_TRUE(scene.Sees(10, [](const auto& s) { return s.gate == GateState::Green; }));
  ASSERT_TRUE(scene.GetsStuck());
  ASSERT_TRUE(Within(10, [&] { return scene.worker->Current()->reason == "registration behind"; }));
  scene.worker->Note("mark", {});
  std::thread stop([&] { scene.worker->Stop(); });
  std::this_thread::sleep_for(100ms);
  scene.stuck->here = false;
  stop.join();
  EXPECT_TRUE(scene.log->Has("registration behind"));
  EXPECT_TRUE(scene.log->Has("mark"));
}

TEST(Worker, AFullDiskEndsTheRecordingNotTheSession) {
  Scene scene(false, 10);
  ASSERT_TRUE(scene.Sees(10, [](const auto& s) { return !s.recording_problem.empty(); }));
  EXPECT_NE(scene.worker->Latest()->recording_problem.find("disk is full"), std::string::npos);
  EXPECT_FALSE(scene.worker->Latest()->recording);
  const int frame = scene.worker->Latest()->frame.index;
  EXPECT_TRUE(scene.Sees(5, [&](const auto& s) { return s.frame.index > frame + 5; }));
  EXPECT_EQ(scene.log->recorded, 10);
}

TEST(Worker, WhatThrowsEndsTheRegistrationAndNothingElse) {
  Scene scene(false, 1 << 20, 20);
  ASSERT_TRUE(scene.Sees(10, [](const auto& s) { return !s.stopped.empty(); }));
  const auto stopped = scene.worker->Latest();
  EXPECT_EQ(stopped->stopped, "the tracker broke");
  EXPECT_EQ(stopped->gate, GateState::Off);
  EXPECT_FALSE(stopped->recording);
  EXPECT_GT(stopped->organ.points.rows(), 0);  // the last model that is whole
  const auto captured = stopped->captured;
  EXPECT_TRUE(scene.Sees(5, [&](const auto& s) { return s.captured > captured; }))
      << "the picture must go on";
  EXPECT_EQ(scene.worker->Latest()->frame.index, -1) << "and is not registered";
  scene.Post(Kind::Undo);  // nobody answers, nothing happens
  scene.worker->Note("mark", {});
  EXPECT_TRUE(Within(5, [&] { return scene.log->Has("mark"); }));
  scene.worker->Stop();
  EXPECT_TRUE(scene.log->Has(kRegistrationStopped));
  EXPECT_TRUE(scene.log->finished) << "what was recorded is completed";
  EXPECT_EQ(scene.worker->RecordingProblem(), "");
  EXPECT_EQ(scene.log->frames.size(), 20u);
}

/// The decisions of a session again, between the same frames, in one thread and without a clock.
Points DoneAgain(const Log& log) {
  BandRun run(true, false);
  auto entry = log.entries.begin();
  for (const int frame : log.frames) {
    for (; entry != log.entries.end() && entry->frame <= frame; ++entry)
      if (auto decision = DecisionOf(*entry, "journal")) Decide(run.session.get(), &*decision);
    run.Next();  // waits for a search that was not late then
  }
  return run.State().positions;
}

TEST(Worker, FramesGoOnWhileASearchIsLateAndAReplayTakesItsAnswerInTheSameFrame) {
  Scene scene(false);
  // Pictures come faster than the search is given for; there is one after another.
  ASSERT_TRUE(Within(60, [&] {
    return scene.log->Has(EventName(Kind::HoldSearch)) &&
           scene.log->Has(EventName(Kind::TakeSearch));
  }));
  scene.worker->Stop();
  const Log& log = *scene.log;
  int late = -1, ready = -1;
  for (const JournalEntry& entry : log.entries) {
    if (entry.event == EventName(Kind::HoldSearch) && late < 0) late = entry.frame;
    if (entry.event == EventName(Kind::TakeSearch) && ready < 0) ready = entry.frame;
  }
  EXPECT_GT(ready, late) << "at least one frame was registered meanwhile";
  const Points again = DoneAgain(log);
  ASSERT_EQ(again.rows(), log.positions.rows());
  EXPECT_TRUE(again == log.positions);
}

TEST(Worker, TheStateBeforeACutIsKept) {
  Scene scene(true);
  ASSERT_TRUE(scene.Sees(20, [](const auto& s) { return !s.cuts.empty(); }));
  EXPECT_EQ(scene.worker->Latest()->cuts[0].before, nullptr);
  const int uncut = scene.worker->Latest()->tetrahedra;
  scene.Post(Kind::AcceptCut, 0);
  ASSERT_TRUE(scene.Sees(5, [](const auto& s) { return s.cuts[0].before != nullptr; }));
  const auto now = scene.worker->Latest();
  EXPECT_EQ(now->cuts[0].before->tetrahedra, uncut);
  EXPECT_LE(now->cuts[0].before->frame.index, now->frame.index);
  EXPECT_NE(now->cuts[0].before->gate, GateState::Off);
  scene.Post(Kind::RejectCut, 0);
  EXPECT_TRUE(scene.Sees(5, [](const auto& s) { return s.cuts[0].before == nullptr; }));
}

}  // namespace
}  // namespace kerf
