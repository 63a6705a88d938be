#pragma once

#include <algorithm>
#include <atomic>
#include <mutex>
#include <thread>

#include "CaseIO/JournalRead.h"
#include "Core/Errors.h"
#include "CrackedBand.h"
#include "Session/IntraoperativeWorker.h"
#include "Support/HeldClock.h"

/// A worker that registers a band whose crack opens, with a source, a clock and a registration that
/// tests hold up, and a sink that may fail.
namespace kerf::testing {

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

}  // namespace kerf::testing
