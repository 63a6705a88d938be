// The worker where sources or the registration stop: losses are not bridged.
#include <gtest/gtest.h>

#include "WorkerScene.h"

namespace kerf {
namespace {

using namespace testing;

TEST(Worker, AFrozenSourceSwitchesTheOverlayOffUntilConfirmed) {
  Scene scene(false);
  ASSERT_TRUE(scene.Sees(10, [](const auto& s) { return s.gate == GateState::Green; }));
  // By the clock of the capture: off where the last picture is half a second old, looks included.
  scene.clock.HoldSince([&] { return scene.capture->State(); }, 0.0);
  *scene.hang = true;
  std::this_thread::sleep_for(100ms);  // what is being read still comes
  scene.clock.HoldSince([&] { return scene.capture->State(); }, 0.3);
  std::this_thread::sleep_for(150ms);
  EXPECT_NE(scene.worker->Latest()->gate, GateState::Off);
  scene.clock.HoldSince([&] { return scene.capture->State(); },
                        0.5 - IntraoperativeWorker::kLook_s);
  ASSERT_TRUE(scene.Sees(10, [](const auto& s) { return s.gate == GateState::Off; }));
  EXPECT_NE(scene.worker->Latest()->reason.find("frozen"), std::string::npos);
  std::this_thread::sleep_for(1200ms);
  scene.clock.GoOn();
  *scene.hang = false;
  ASSERT_TRUE(scene.Sees(3, [](const auto& s) {
    return s.source.kind == SourceState::Kind::Running && s.needs_confirmation;
  }));
  EXPECT_EQ(scene.worker->Latest()->gate, GateState::Off);
  scene.Post(Kind::Confirm);
  EXPECT_TRUE(scene.Sees(
      3, [](const auto& s) { return s.gate != GateState::Off && !s.needs_confirmation; }));
  EXPECT_TRUE(scene.log->Has("source lost"));
  EXPECT_TRUE(scene.log->Has("registration confirmed"));
}

TEST(Worker, PicturesGoOnWithoutTheOverlayWhileTheRegistrationIsBehind) {
  Scene scene(false);
  ASSERT_TRUE(scene.Sees(10, [](const auto& s) { return s.gate == GateState::Green; }));
  EXPECT_TRUE(Within(10, [&] { return scene.worker->Current()->gate == GateState::Green; }));
  ASSERT_TRUE(scene.GetsStuck());
  const auto registered = scene.worker->Latest();
  ASSERT_TRUE(Within(10, [&] { return scene.capture->FirstAfter(registered->captured); }));
  const auto waits = *scene.capture->FirstAfter(registered->captured);
  EXPECT_EQ(scene.worker->Current(waits + 300ms), registered);
  const auto behind = scene.worker->Current(waits + 500ms);
  EXPECT_EQ(behind->gate, GateState::Off);
  EXPECT_EQ(behind->reason, "registration behind");
  EXPECT_GT(behind->captured, registered->captured);
  // Its own stamp, not that of the picture that is registered.
  EXPECT_EQ(behind->frame.index, -1);
  EXPECT_NEAR(behind->frame.time_s - registered->frame.time_s,
              std::chrono::duration<double>(behind->captured - registered->captured).count(), 1e-6);
  ASSERT_TRUE(Within(10, [&] { return scene.capture->Newest()->captured > behind->captured; }));
  EXPECT_GT(scene.worker->Current(waits + 550ms)->captured, behind->captured) << "the newest only";
  EXPECT_EQ(scene.worker->Latest(), registered);
  // No flicker: what was too late is back once it is well in time.
  EXPECT_EQ(scene.worker->Current(waits + 210ms)->reason, "registration behind");
  EXPECT_EQ(scene.worker->Current(waits + 190ms), registered);
  EXPECT_EQ(scene.worker->Current(waits + 390ms), registered);
  scene.stuck->here = false;
  EXPECT_TRUE(Within(10, [&] { return scene.worker->Current()->gate == GateState::Green; }));
  ASSERT_TRUE(Within(10, [&] { return scene.log->Has("registration caught up"); }));
  scene.worker->Stop();
  const auto& entries = scene.log->entries;
  const auto said = std::find_if(entries.begin(), entries.end(), [](const JournalEntry& entry) {
    return entry.event == "registration behind";
  });
  ASSERT_NE(said, entries.end());
  EXPECT_NEAR(*said->Number("waited_s"), 0.5, 1e-6);
}

/// Whether or not anybody looked meanwhile.
TEST(Worker, ALongHangOfTheRegistrationIsALossToBeConfirmed) {
  for (const bool looked : {false, true}) {
    Scene scene(false);
    ASSERT_TRUE(scene.Sees(10, [](const auto& s) { return s.gate == GateState::Green; }));
    ASSERT_TRUE(scene.GetsStuck());
    const auto until = Clock::now() + 1600ms;
    while (Clock::now() < until) {
      if (looked) scene.worker->Current();
      std::this_thread::sleep_for(10ms);
    }
    scene.Post(Kind::Confirm);  // of a registration that nobody has seen
    scene.stuck->here = false;
    ASSERT_TRUE(Within(10, [&] {
      const auto current = scene.worker->Current();
      return current->needs_confirmation && current->reason.find("confirm") != std::string::npos;
    }));
    std::this_thread::sleep_for(300ms);  // it does not come back by itself
    EXPECT_EQ(scene.worker->Current()->gate, GateState::Off);
    EXPECT_TRUE(scene.worker->Current()->needs_confirmation);
    scene.Post(Kind::Confirm);
    EXPECT_TRUE(Within(10, [&] {
      return scene.worker->Current()->gate == GateState::Green &&
             !scene.worker->Current()->needs_confirmation;
    }));
    scene.worker->Stop();
    int needed = 0;
    for (const JournalEntry& entry : scene.log->entries)
      if (entry.event == "confirmation needed") {
        EXPECT_EQ(*entry.Text("reason"), "registration behind");
        ++needed;
      }
    EXPECT_GE(needed, 1);
  }
}

/// A video that ends with a slow frame.
TEST(Worker, TheFrameThatEndsAHangIsOnWhereNothingWaitsBehindIt) {
  Scene scene(false);
  ASSERT_TRUE(scene.Sees(10, [](const auto& s) { return s.gate == GateState::Green; }));
  ASSERT_TRUE(scene.GetsStuck());
  scene.HoldClock();
  ASSERT_TRUE(scene.Later(0.04));
  ASSERT_TRUE(scene.Later(0.45));
  const auto last = scene.PicturesEnd();
  EXPECT_EQ(scene.worker->Current()->reason, "registration behind");
  scene.stuck->here = false;
  ASSERT_TRUE(scene.Sees(10, [&](const auto& s) { return s.captured == last; }));
  // Whoever asks, and whoever does not.
  EXPECT_EQ(scene.worker->Latest()->gate, GateState::Green);
  EXPECT_EQ(scene.worker->Current(), scene.worker->Latest());
  EXPECT_FALSE(scene.worker->Latest()->needs_confirmation);
}

/// In the round right after the frame that ended the hang: what was seen and confirmed is, and the
/// hang of before does not count again.
TEST(Worker, AConfirmationRightAfterAHangNeedsNoSecondOne) {
  Scene scene(false);
  ASSERT_TRUE(scene.Sees(10, [](const auto& s) { return s.gate == GateState::Green; }));
  std::atomic<int> pressed{0};
  scene.on_snapshot = [&] {
    if (!scene.worker->Latest()->needs_confirmation || pressed++ > 0) return;
    scene.Post(Kind::Confirm);
  };
  ASSERT_TRUE(scene.GetsStuck());
  scene.HoldClock();
  ASSERT_TRUE(scene.Later(0.04));
  ASSERT_TRUE(scene.Later(1.6));
  scene.listens = true;
  scene.stuck->here = false;
  ASSERT_TRUE(Within(10, [&] { return pressed > 0; }));
  // Amber for a second, since pictures were passed over; and time stands still here.
  EXPECT_TRUE(scene.Sees(
      10, [](const auto& s) { return s.gate != GateState::Off && !s.needs_confirmation; }));
  scene.worker->Stop();
  EXPECT_EQ(scene.Count("confirmation needed"), 1);
  EXPECT_EQ(scene.Count("registration confirmed"), 1);
}

TEST(Worker, AConfirmationWhileThePictureIsGoneCountsForNothing) {
  Scene scene(false);
  ASSERT_TRUE(scene.Sees(10, [](const auto& s) { return s.gate == GateState::Green; }));
  *scene.hang = true;
  ASSERT_TRUE(scene.Sees(10, [](const auto& s) { return s.needs_confirmation; }));
  ASSERT_FALSE(scene.worker->Latest()->source.Usable());
  scene.Post(Kind::Confirm);  // of a picture that is not there
  ASSERT_TRUE(scene.Sees(10, [](const auto& s) {
    return s.said == "Not confirmed: nothing could be checked at that moment.";
  }));
  *scene.hang = false;
  EXPECT_FALSE(scene.Sees(2, [](const auto& s) { return s.gate != GateState::Off; }));
  scene.Post(Kind::Confirm);  // of one that is
  EXPECT_TRUE(scene.Sees(10, [](const auto& s) { return s.gate != GateState::Off; }));
}

/// Asked after the first hang, pressed in the second: of what came meanwhile nobody has seen a
/// thing.
TEST(Worker, AConfirmationInASecondHangCountsForNothing) {
  Scene scene(false);
  ASSERT_TRUE(scene.Sees(10, [](const auto& s) { return s.gate == GateState::Green; }));
  ASSERT_TRUE(scene.GetsStuck());
  scene.HoldClock();
  ASSERT_TRUE(scene.Later(0.04));
  ASSERT_TRUE(scene.Later(1.6));
  scene.stuck->here = false;
  ASSERT_TRUE(scene.Sees(10, [](const auto& s) { return s.needs_confirmation; }));
  ASSERT_TRUE(scene.GetsStuck());
  ASSERT_TRUE(scene.Later(0.04));
  ASSERT_TRUE(scene.Later(3.0));
  EXPECT_EQ(scene.worker->Current()->reason, "registration behind");
  scene.Post(Kind::Confirm);
  scene.stuck->here = false;
  EXPECT_FALSE(scene.Sees(2, [](const auto& s) { return s.gate != GateState::Off; }));
  EXPECT_EQ(scene.Count("registration confirmed"), 0);
}

/// Off, since every picture is late, but nothing is lost: the surgeon is asked for nothing.
TEST(Worker, ASlowRegistrationIsSaidWithItsRateAndAsksForNothing) {
  Scene scene(false);
  ASSERT_TRUE(scene.Sees(10, [](const auto& s) { return s.gate == GateState::Green; }));
  ASSERT_TRUE(scene.GetsStuck());
  scene.HoldClock();
  for (int slow = 0; slow < 9; ++slow) {  // one picture every 0.3 s
    ASSERT_TRUE(scene.Later(0.04));
    ASSERT_TRUE(scene.Later(0.26));
    const auto before = scene.worker->Latest();
    scene.stuck->passes = 1;
    ASSERT_TRUE(Within(10, [&] { return scene.stuck->waits && scene.worker->Latest() != before; }));
    EXPECT_FALSE(scene.worker->Current()->needs_confirmation) << slow;
    if (slow < 2) continue;
    EXPECT_EQ(scene.worker->Current()->gate, GateState::Off) << slow;
    EXPECT_EQ(scene.worker->Current()->reason, "registration behind: 3 pictures a second") << slow;
  }
  scene.Post(Kind::Confirm);  // of nothing
  scene.stuck->here = false;  // fast again: it is back by itself
  EXPECT_TRUE(scene.Sees(10, [](const auto& s) {
    return s.gate == GateState::Green && s.said == "There is nothing to confirm.";
  }));
  EXPECT_EQ(scene.Count("confirmation needed"), 0);
  EXPECT_EQ(scene.Count("registration confirmed"), 0);
  // Nothing at all for longer is stuck, and a loss.
  ASSERT_TRUE(scene.GetsStuck());
  ASSERT_TRUE(scene.Later(0.04));
  ASSERT_TRUE(scene.Later(2.5));
  EXPECT_EQ(scene.worker->Current()->reason, "registration behind");
  scene.stuck->here = false;
  EXPECT_TRUE(scene.Sees(10, [](const auto& s) { return s.needs_confirmation; }));
}

/// Setting the model up takes a while, and pictures come meanwhile.
TEST(Worker, TheFirstFrameIsNotLate) {
  Scene scene(false, 1 << 20, 1 << 20, 700ms);
  ASSERT_TRUE(Within(20, [&] { return scene.worker->Current() != nullptr; }));
  EXPECT_NE(scene.worker->Current()->reason, "registration behind");
  ASSERT_TRUE(Within(10, [&] { return scene.worker->Current()->frame.index > 3; }));
  scene.worker->Stop();
  EXPECT_FALSE(scene.log->Has("registration behind"));
}

/// A source that paused is nothing that the registration is late for.
TEST(Worker, APauseOfTheSourceIsNoRegistrationThatIsBehind) {
  Scene scene(false);
  ASSERT_TRUE(scene.Sees(10, [](const auto& s) { return s.gate == GateState::Green; }));
  *scene.hang = true;
  std::this_thread::sleep_for(700ms);
  scene.stuck->here = true;
  *scene.hang = false;
  ASSERT_TRUE(Within(10, [&] { return scene.stuck->waits.load(); }));
  const auto registered = scene.worker->Latest();
  ASSERT_TRUE(Within(10, [&] { return scene.capture->FirstAfter(registered->captured); }));
  const auto waits = *scene.capture->FirstAfter(registered->captured);
  EXPECT_GT(waits - registered->captured, 500ms);
  EXPECT_NE(scene.worker->Current(waits + 300ms)->reason, "registration behind");
}

}  // namespace
}  // namespace kerf
