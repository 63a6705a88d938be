#include "Session/IntraoperativeCapture.h"

#include <algorithm>
#include <condition_variable>
#include <cstring>
#include <deque>
#include <mutex>
#include <thread>

#include "Core/Errors.h"
#include "Session/RateMeter.h"

namespace kerf {
namespace {

using Clock = std::chrono::steady_clock;
constexpr std::size_t kTimesKept = 256;  // some seconds of any source

double Seconds(Clock::duration d) { return std::chrono::duration<double>(d).count(); }

bool SamePicture(const Frame& a, const Frame& b) {
  return a.image && b.image && a.image->data.size() == b.image->data.size() &&
         std::memcmp(a.image->data.data(), b.image->data.data(), a.image->data.size()) == 0;
}

}  // namespace

struct IntraoperativeCapture::Shared {
  CaptureOptions options;
  mutable std::mutex mutex;
  std::condition_variable changed;
  bool stop = false, held = false, finished = false;
  std::optional<CapturedFrame> newest;
  bool taken = true;  ///< nobody waits for `newest`
  SourceState state;
  Clock::time_point last_new;  ///< when a picture came that differs from the one before
  RateMeter arrivals;
  std::deque<Clock::time_point> times;  ///< of the last frames

  void Say(SourceState::Kind kind, const std::string& message) {
    const std::lock_guard lock(mutex);
    state.kind = kind;
    state.message = message;
    changed.notify_all();
  }
  /// @return false when the capture is to stop
  bool Wait(double seconds) {
    std::unique_lock lock(mutex);
    changed.wait_for(lock, std::chrono::duration<double>(seconds), [&] { return stop; });
    return !stop;
  }
  void Deliver(Frame frame) {
    std::unique_lock lock(mutex);
    if (options.every) changed.wait(lock, [&] { return stop || taken; });
    const auto now = options.clock();
    const bool repeated = newest && SamePicture(frame, newest->frame);
    if (!repeated) last_new = now;
    if (repeated && options.live) return;  // a grabber without a signal repeats its last picture
    if (!taken) ++state.dropped;
    frame.index = state.delivered++;
    newest = CapturedFrame{std::move(frame), now};
    taken = false;
    arrivals.Add(now);
    times.push_back(now);
    if (times.size() > kTimesKept) times.pop_front();
    changed.notify_all();
    if (options.hold && held) changed.wait(lock, [&] { return stop || !held; });
  }
  /// Reads one opened source until it ends. @return true when that was its proper end
  bool Read(FrameSource* source) {
    const double period_s = 1.0 / std::max(1.0, source->FramesPerSecond());
    auto due = Clock::now();
    int read = 0;
    while (true) {
      {
        const std::lock_guard lock(mutex);
        if (stop) return true;
      }
      std::optional<Frame> frame = source->Next();
      if (!frame) return source->FrameCount() < 0 ? false : read >= source->FrameCount();
      ++read;
      const auto before = Clock::now();
      Deliver(std::move(*frame));
      if (options.live || !options.paced) continue;
      // What holding took is not made up for by running faster.
      if (Seconds(Clock::now() - before) > period_s) due = Clock::now();
      due += std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(period_s));
      const double wait_s = Seconds(due - Clock::now());
      if (wait_s > 0 && !Wait(wait_s)) return true;
    }
  }
};

IntraoperativeCapture::IntraoperativeCapture(Opener open, const CaptureOptions& options)
    : shared_(std::make_shared<Shared>()) {
  shared_->options = options;
  shared_->held = options.hold;
  shared_->last_new = options.clock();
  std::thread(Run, shared_, std::move(open)).detach();
}

IntraoperativeCapture::~IntraoperativeCapture() {
  std::unique_lock lock(shared_->mutex);
  shared_->stop = true;
  shared_->changed.notify_all();
  // A device that hangs in a read keeps its thread and what it shares; nobody waits for it longer.
  shared_->changed.wait_for(lock, std::chrono::seconds(1), [&] { return shared_->finished; });
}

void IntraoperativeCapture::Run(std::shared_ptr<Shared> shared, Opener open) {
  const auto stopped = [&] {
    const std::lock_guard lock(shared->mutex);
    return shared->stop;
  };
  bool opened_before = false;
  while (!stopped()) {
    std::string problem;
    try {
      const std::unique_ptr<FrameSource> source = open();
      {
        const std::lock_guard lock(shared->mutex);
        shared->state.width = source->Width();
        shared->state.height = source->Height();
        shared->state.nominal_fps = source->FramesPerSecond();
        shared->state.reconnects += opened_before;
        shared->last_new = shared->options.clock();
        shared->state.kind = SourceState::Kind::Running;
        shared->state.message.clear();
      }
      opened_before = true;
      const bool ended = shared->Read(source.get());
      if (stopped()) break;
      if (ended && !shared->options.live) {
        shared->Say(SourceState::Kind::Ended, "The video has ended.");
        break;
      }
      problem = "No more pictures come from the source.";
    } catch (const std::exception& error) {
      problem = error.what();
    }
    if (stopped()) break;
    if (!shared->options.live) {
      shared->Say(SourceState::Kind::Lost, problem);
      break;
    }
    shared->Say(SourceState::Kind::Lost, problem + " Trying again.");
    if (!shared->Wait(shared->options.retry_after_s)) break;
  }
  const std::lock_guard lock(shared->mutex);
  shared->finished = true;
  shared->changed.notify_all();
}

std::optional<CapturedFrame> IntraoperativeCapture::Take(double timeout_s) {
  std::unique_lock lock(shared_->mutex);
  const auto& s = *shared_;
  shared_->changed.wait_for(lock, std::chrono::duration<double>(timeout_s),
                            [&] { return s.stop || !s.taken; });
  if (shared_->taken || !shared_->newest) return std::nullopt;
  shared_->taken = true;
  shared_->changed.notify_all();
  return shared_->newest;
}

std::optional<CapturedFrame> IntraoperativeCapture::Newest() const {
  const std::lock_guard lock(shared_->mutex);
  return shared_->newest;
}

std::optional<Clock::time_point> IntraoperativeCapture::FirstAfter(
    Clock::time_point captured) const {
  if (shared_->options.every) return std::nullopt;
  const std::lock_guard lock(shared_->mutex);
  const auto& times = shared_->times;
  const auto after = std::upper_bound(times.begin(), times.end(), captured);
  return after == times.end() ? std::nullopt : std::optional(*after);
}

Clock::time_point IntraoperativeCapture::Now() const { return shared_->options.clock(); }

void IntraoperativeCapture::Resume() {
  const std::lock_guard lock(shared_->mutex);
  shared_->held = false;
  shared_->last_new = shared_->options.clock();
  shared_->changed.notify_all();
}

SourceState IntraoperativeCapture::State() const {
  const std::lock_guard lock(shared_->mutex);
  SourceState state = shared_->state;
  const auto now = shared_->options.clock();
  state.silence_s = Seconds(now - shared_->last_new);
  state.fps = shared_->arrivals.PerSecond(now);
  const bool waits = shared_->held && shared_->newest;  // on purpose
  if (state.kind == SourceState::Kind::Running && !waits && !shared_->options.every &&
      state.silence_s > shared_->options.frozen_after_s) {
    state.kind = SourceState::Kind::Frozen;
    state.message = "The picture has been frozen for " +
                    std::to_string(int(state.silence_s * 10) / 10) + "." +
                    std::to_string(int(state.silence_s * 10) % 10) + " s.";
  }
  return state;
}

}  // namespace kerf
