// The worker: snapshots out, decisions in, a recording that may fail, losses that are not bridged.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <mutex>
#include <thread>

#include "CaseIO/JournalRead.h"
#include "Core/Errors.h"
#include "CrackedBand.h"
#include "Session/IntraoperativeWorker.h"
#include "Support/HeldClock.h"

namespace kerf {
namespace {

using namespace testing;
using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

template <class F>
bool Within(double seconds, F condition) {
  const auto until = Clock::now() + std::chrono::duration<double>(seconds);
  while (!condition()) {
    if (Clock::now() > until) return false;
    std::this_thread::sleep_for(2ms);
  }
  return true;
}

struct Log {
  std::mutex mutex;
  std::vector<std::string> events;
  std::vector<JournalEntry> entries;  ///< the same, with what belongs to them
  std::vector<int> frames;
  Points positions;  ///< after the last of them
  std::atomic<int> recorded{0};
  std::atomic<bool> finished{false};
  int full_at = 1 << 20;
  std::atomic<bool> full{false};  ///< the journal takes no line any more
  bool Has(const std::string& event) {
    const std::lock_guard lock(mutex);
    return std::count(events.begin(), events.end(), event) > 0;
  }
};

class LogSink : public IntraoperativeSink {
 public:
  explicit LogSink(std::shared_ptr<Log> log) : log_(std::move(log)) {}
  Frame Record(const CapturedFrame& captured, int number, double time_s) override {
    if (number >= log_->full_at) throw InputError("frames.csv", "", "the disk is full");
    ++log_->recorded;
    Frame frame = captured.frame;
    frame.index = number;
    frame.time_s = time_s;
    return frame;
  }
  void Registered(const SessionFrame& frame, const RegistrationState& state) override {
    const std::lock_guard lock(log_->mutex);
    log_->frames.push_back(frame.frame);
    log_->positions = state.positions;
  }
  void Say(double time_s, int frame, const std::string& event, const JournalData& data) override {
    const std::lock_guard lock(log_->mutex);
    if (log_->full) throw InputError("journal.jsonl", "", "No space left on device");
    log_->events.push_back(event);
    log_->entries.push_back({time_s, frame, event, data});
  }
  void Finish(const RegistrationState&, const SessionFrame&) override { log_->finished = true; }

 private:
  std::shared_ptr<Log> log_;
};

/// Endless: the crack opens and stays; every frame has a picture of its own.
class BandSource : public FrameSource {
 public:
  explicit BandSource(std::shared_ptr<std::atomic<bool>> hang) : hang_(std::move(hang)) {}
  std::optional<Frame> Next() override {
    std::this_thread::sleep_for(8ms);
    while (*hang_) std::this_thread::sleep_for(5ms);
    Frame frame;
    frame.index = next_++;
    return frame;
  }
  int Width() const override { return 960; }
  int Height() const override { return 540; }
  double FramesPerSecond() const override { return 100; }
  int FrameCount() const override { return -1; }

 private:
  std::shared_ptr<std::atomic<bool>> hang_;
  int next_ = 0;
};

struct Scene {
  explicit Scene(bool hold, int full_at = 1 << 20, int throw_at = 1 << 20,
                 std::chrono::milliseconds detecting = 0ms) {
    stuck->detecting = detecting;
    log->full_at = full_at;
    CaptureOptions options;
    options.live = true;
    options.clock = clock;
    IntraoperativeWorker::Parts parts;
    BandRun run(true, hold, 1 << 20, throw_at, true, stuck);
    parts.session = std::move(run.session);
    parts.uncut = BoundarySurface(BandMesh(3000), BandMesh(3000).rest);
    auto flag = hang;
    parts.capture = capture = std::make_shared<IntraoperativeCapture>(
        [flag]() -> std::unique_ptr<FrameSource> { return std::make_unique<BandSource>(flag); },
        options);
    parts.sink = std::make_unique<LogSink>(log);
    parts.on_snapshot = [this] {
      if (listens) on_snapshot();
    };
    worker = std::make_unique<IntraoperativeWorker>(std::move(parts));
  }
  ~Scene() { stuck->here = *hang = false; }  // whatever failed, the worker can end
  /// Nothing is registered any more when this returns.
  bool GetsStuck() {
    stuck->here = true;
    return Within(10, [&] { return stuck->waits.load(); });
  }
  /// The clock stands still; pictures come on.
  void HoldClock() {
    clock.HoldSince([&] { return capture->State(); }, 0.0);
  }
  /// `seconds` later by the clock that is held, and a picture of then has come.
  bool Later(double seconds) {
    const auto now_came = [&] { return capture->Newest()->captured == clock(); };
    if (!Within(10, now_came)) return false;
    clock.HoldSince([&] { return capture->State(); }, seconds);
    return Within(10, now_came);
  }
  /// No picture comes after this. @return when the last one did
  Clock::time_point PicturesEnd() {
    *hang = true;
    std::this_thread::sleep_for(100ms);  // what is being read still comes
    return capture->Newest()->captured;
  }
  int Count(const std::string& event) {
    const std::lock_guard lock(log->mutex);
    return int(std::count(log->events.begin(), log->events.end(), event));
  }
  template <class F>
  bool Sees(double seconds, F condition) {
    return Within(seconds, [&] {
      const auto latest = worker->Latest();
      return latest && condition(*latest);
    });
  }
  void Post(IntraoperativeDecision::Kind kind, int cut = -1) {
    IntraoperativeDecision decision;
    decision.kind = kind;
    decision.cut = cut;
    worker->Post(decision);
  }
  std::shared_ptr<Log> log = std::make_shared<Log>();
  std::shared_ptr<std::atomic<bool>> hang = std::make_shared<std::atomic<bool>>(false);
  std::shared_ptr<CrackTracker::Stuck> stuck = std::make_shared<CrackTracker::Stuck>();
  HeldClock clock;
  std::shared_ptr<IntraoperativeCapture> capture;
  std::function<void()> on_snapshot;  ///< in the worker's thread, while it `listens`
  std::atomic<bool> listens{false};
  std::unique_ptr<IntraoperativeWorker> worker;
};

using Kind = IntraoperativeDecision::Kind;

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
