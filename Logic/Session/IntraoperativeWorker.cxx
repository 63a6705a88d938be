#include "Session/IntraoperativeWorker.h"

#include <deque>
#include <mutex>
#include <thread>

#include "Session/AppliedCuts.h"
#include "Session/RateMeter.h"
#include "Session/SolverPace.h"

namespace kerf {
namespace {

using Clock = std::chrono::steady_clock;
constexpr double kBehind_s = 0.4;    // a picture that waits for longer than this to be registered
constexpr double kCaughtUp_s = 0.2;  // behind until none waits for longer than this
constexpr int kSettle = 15;          // looks at the last picture of all after a decision
constexpr double kStuck_s = 2.0;     // nothing since a picture as old as this is not slow any more
constexpr double kLossToConfirm_s = 1.0;  // off for longer than this: the surgeon confirms
constexpr char kBehindReason[] = "registration behind";

double Seconds(Clock::duration d) { return std::chrono::duration<double>(d).count(); }

bool IsBehindReason(const std::string& reason) { return reason.rfind(kBehindReason, 0) == 0; }

/// Slow, frame after frame, is something else than stuck.
std::string SlowReason(double registered_fps) {
  const int rate = static_cast<int>(registered_fps);
  if (rate < 1) return kBehindReason;
  return std::string(kBehindReason) + ": " + std::to_string(rate) +
         (rate > 1 ? " pictures a second" : " picture a second");
}

}  // namespace

struct IntraoperativeWorker::Implementation {
  explicit Implementation(Parts given)
      : parts(std::move(given)),
        maker(parts.uncut, parts.plan),
        pace(parts.deadline_ms),
        recording_problem(parts.recording_problem) {}

  Parts parts;
  SnapshotMaker maker;
  std::thread thread;

  std::mutex joining;  ///< several threads may stop it
  mutable std::mutex mutex;
  bool stop = false;
  struct Posted {
    IntraoperativeDecision decision;
    int asked;  ///< by `asks`, when it was posted
  };
  std::deque<Posted> posted;
  std::deque<std::pair<std::string, JournalData>> notes;
  std::shared_ptr<const IntraoperativeSnapshot> latest;
  int latest_asks = 0;  ///< `asks` of that

  // The worker's own.
  int frames = 0;
  Clock::time_point started;
  double time_s = 0.0;
  RateMeter registered;
  std::optional<Clock::time_point> off_since;
  Clock::time_point nothing_before;  ///< last registered, or confirmed: what was before is no hang
  std::string off_reason, loss_reason;  ///< last; of the loss that is to be confirmed
  bool needs_confirmation = false;
  int losses = 0;  ///< grows while one lasts
  int asks = 0;    ///< after which of them the surgeon can look and confirm; 0: nothing to look at
  SourceState::Kind source_kind = SourceState::Kind::Running;
  SolverPace pace;
  int solver_limit = 0;
  bool search_held = false;
  std::string recording_problem, said, stopped;
  std::optional<std::vector<CutRecord>> cuts;
  int said_number = 0;
  SessionFrame last;
  std::optional<CapturedFrame> last_captured;

  /// Whether registration is behind; of the worker and of whoever asks what is to be shown.
  std::mutex showing;
  Clock::time_point first_shown;  ///< the model is set up in the first frame: none is late before
  std::optional<Clock::time_point> behind_since;  ///< when the picture that waits waited too long
  /// What is shown meanwhile, and after which registered one.
  std::shared_ptr<const IntraoperativeSnapshot> behind, behind_after;

  bool Stopped() const {
    const std::lock_guard lock(mutex);
    return stop;
  }
  /// Recording must never end a session: what cannot be written is said.
  template <class F>
  void WithSink(F f) {
    if (!parts.sink) return;
    try {
      f(*parts.sink);
    } catch (const std::exception& error) {
      recording_problem = error.what();
      parts.sink.reset();
    }
  }
  void Say(const std::string& event, const JournalData& data = {}) {
    WithSink([&](IntraoperativeSink& sink) { sink.Say(time_s, frames, event, data); });
  }

  std::shared_ptr<const IntraoperativeSnapshot> Latest() const {
    const std::lock_guard lock(mutex);
    return latest;
  }

  void Note(const std::string& event, const JournalData& data) {
    const std::lock_guard lock(mutex);
    notes.push_back({event, data});
  }
  std::optional<Clock::time_point> BehindSince(const IntraoperativeSnapshot& registered_one,
                                               Clock::time_point now);
  bool IsBehind(const IntraoperativeSnapshot& registered_one, Clock::time_point now);
  std::shared_ptr<const IntraoperativeSnapshot> Current(Clock::time_point now);

  void Run();
  void Round();
  void GoOnWithout(const std::string& why);
  void Register(const CapturedFrame& captured);
  void CarryOut(IntraoperativeDecision decision, int asked = 0);
  void Answer(const std::string& words) {
    said = words;
    ++said_number;
  }
  void DecideByTheClock(IntraoperativeDecision decision);
  void KeepDeadline();
  void DoNotWaitForSearch();
  void WatchSource();
  void Gate(const SourceState& source, IntraoperativeSnapshot* out);
  /// A picture that was not registered, in a session: without a number.
  Frame Unregistered(const CapturedFrame& captured) const {
    Frame frame = captured.frame;
    frame.index = -1;
    frame.time_s = Seconds(captured.captured - started);
    return frame;
  }
  /// After Gate(), which writes to the journal, too.
  void SayRecording(IntraoperativeSnapshot* out) const {
    out->recording = parts.sink != nullptr;
    out->recording_problem = recording_problem;
  }
  void SayNotes() {
    std::deque<std::pair<std::string, JournalData>> lines;
    {
      const std::lock_guard lock(mutex);
      lines.swap(notes);
    }
    for (const auto& [event, data] : lines) Say(event, data);
  }
  std::shared_ptr<IntraoperativeSnapshot> Describe(const Frame& frame, const SessionFrame& report,
                                                   Clock::time_point captured);
  void Publish(std::shared_ptr<const IntraoperativeSnapshot> snapshot) {
    {
      const std::lock_guard lock(mutex);
      latest = std::move(snapshot);
      latest_asks = asks;
    }
    if (parts.on_snapshot) parts.on_snapshot();
  }
};

void IntraoperativeWorker::Implementation::CarryOut(IntraoperativeDecision decision, int asked) {
  if (frames == 0) return;  // there is no state to decide about yet
  const bool confirms = decision.kind == IntraoperativeDecision::Kind::Confirm;
  // Of what was seen: not while the picture is gone, nor of what came after the key was pressed.
  if (confirms && !(needs_confirmation && asked > 0 && asked == losses))
    return Answer(needs_confirmation ? "Not confirmed: nothing could be checked at that moment."
                                     : "There is nothing to confirm.");
  const DecisionOutcome outcome = Decide(parts.session.get(), &decision);
  Answer(outcome.words);
  if (!outcome.done) return;
  if (confirms) {
    needs_confirmation = false;
    off_since.reset();
    nothing_before = parts.capture->Now();
  }
  for (const auto& [event, data] : JournalLines(decision, outcome, parts.session->State()))
    Say(event, data);
}

/// Unlike a surgeon's, without words.
void IntraoperativeWorker::Implementation::DecideByTheClock(IntraoperativeDecision decision) {
  Decide(parts.session.get(), &decision);
  Say(EventName(decision.kind), ToJournal(decision));
}

/// A search that shares the cores with the window may take longer than the frames that it is given.
void IntraoperativeWorker::Implementation::DoNotWaitForSearch() {
  const bool is_late = parts.deadline_ms > 0.0 && parts.session->SearchIsLate(frames);
  if (is_late == search_held) return;
  search_held = is_late;
  IntraoperativeDecision decision;
  decision.kind =
      is_late ? IntraoperativeDecision::Kind::HoldSearch : IntraoperativeDecision::Kind::TakeSearch;
  DecideByTheClock(decision);
}

void IntraoperativeWorker::Implementation::KeepDeadline() {
  if (!last.step.cuts.empty()) return;  // most of their time does not come from iterations
  pace.Note(last.times.Sum(), last.times.solve_ms, last.step.solve.cg_iterations);
  if (pace.Limit() == solver_limit) return;
  IntraoperativeDecision decision;
  decision.kind = IntraoperativeDecision::Kind::LimitSolver;
  decision.iterations = solver_limit = pace.Limit();
  DecideByTheClock(decision);
}

void IntraoperativeWorker::Implementation::Gate(const SourceState& source,
                                                IntraoperativeSnapshot* out) {
  const auto now = parts.capture->Now();
  out->gate = out->reliability.state;
  out->reason = out->reliability.reason;
  out->stopped = stopped;
  asks = 0;
  if (!stopped.empty()) {
    out->gate = GateState::Off;
    out->reason = "the registration has stopped: register again";
    out->needs_confirmation = false;
    return;
  }
  if (!source.Usable()) {
    out->gate = GateState::Off;
    out->reason = source.message.empty() ? "no picture" : source.message;
  }
  const bool is_lost = out->gate == GateState::Off;
  // A hang is noticed by the frame that ends it, and counts even if nothing waits behind that one.
  // One frame after the other, each late, is no hang: nothing is lost where registration is slow.
  std::optional<Clock::time_point> hangs_since;
  if (const auto registered_one = Latest()) {
    if (const auto since = BehindSince(*registered_one, now))
      hangs_since = std::max(*since, nothing_before);
    if (BehindSince(*out, now) && !is_lost) {
      out->gate = GateState::Off;
      out->reason =
          IsBehindReason(registered_one->reason)
              ? SlowReason(std::min(registered.PerSecond(now), 1.0 / Seconds(now - nothing_before)))
              : kBehindReason;
    }
  }
  if (is_lost) {
    off_reason = out->reason;
    off_since = std::min(off_since.value_or(now), hangs_since.value_or(now));
  }
  // A loss is never bridged: whether the model is right again is for the surgeon to say.
  const auto since = std::min(off_since.value_or(now), hangs_since.value_or(now));
  const bool is_long = Seconds(now - since) > kLossToConfirm_s;
  losses += is_long;
  if (!needs_confirmation && is_long) {
    needs_confirmation = true;
    loss_reason = is_lost || !hangs_since ? off_reason : kBehindReason;
    Say("confirmation needed", {{"reason", loss_reason}});
  }
  out->needs_confirmation = needs_confirmation;
  if (!is_lost && needs_confirmation) asks = losses;
  const bool is_off = out->gate == GateState::Off;
  if (is_off) return;
  off_since.reset();
  if (!needs_confirmation) return;
  out->gate = GateState::Off;
  out->reason = loss_reason == kBehindReason
                    ? "registration has caught up: check it and confirm"
                    : "the picture is back: check the registration and confirm";
}

/// None where no picture that came after this one has waited for too long.
std::optional<Clock::time_point> IntraoperativeWorker::Implementation::BehindSince(
    const IntraoperativeSnapshot& registered_one, Clock::time_point now) {
  const std::lock_guard lock(showing);
  return IsBehind(registered_one, now) ? behind_since : std::nullopt;
}

/// `showing` is held.
bool IntraoperativeWorker::Implementation::IsBehind(const IntraoperativeSnapshot& registered_one,
                                                    Clock::time_point now) {
  // From the first frame that waits on: a source that paused is nothing to be late for.
  const auto waits = parts.capture->FirstAfter(registered_one.captured);
  const auto since = waits ? std::max(*waits, first_shown) : now;
  const double waited_s = Seconds(now - since);
  if (behind_since && waited_s < kCaughtUp_s) {
    Note("registration caught up", {});
    behind_since.reset();
    behind.reset();
  } else if (!behind_since && waited_s > kBehind_s) {
    Note(kBehindReason, {{"waited_s", waited_s}});
    behind_since = since + std::chrono::duration_cast<Clock::duration>(
                               std::chrono::duration<double>(kBehind_s));
  }
  return behind_since.has_value();
}

std::shared_ptr<IntraoperativeSnapshot> IntraoperativeWorker::Implementation::Describe(
    const Frame& frame, const SessionFrame& report, Clock::time_point captured) {
  auto out = maker.Make(frame, report, parts.session->State());
  out->captured = captured;
  const auto now = parts.capture->Now();
  registered.Add(now);
  out->registered_fps = registered.PerSecond(now);
  out->source = parts.capture->State();
  Gate(out->source, out.get());
  SayRecording(out.get());
  out->said = said;
  out->said_number = said_number;
  return out;
}

void IntraoperativeWorker::Implementation::Register(const CapturedFrame& captured) {
  if (frames == 0) started = captured.captured;
  time_s = std::max(time_s, Seconds(captured.captured - started));
  Frame frame = captured.frame;
  frame.index = frames;
  frame.time_s = time_s;
  WithSink([&](IntraoperativeSink& sink) { frame = sink.Record(captured, frames, time_s); });
  DoNotWaitForSearch();
  last = parts.session->Process(frame);
  ++frames;
  WithSink([&](IntraoperativeSink& sink) { sink.Registered(last, parts.session->State()); });
  KeepDeadline();
  if (frames == 1)
    for (const IntraoperativeDecision& decision : parts.first) CarryOut(decision);
  const auto described = Describe(frame, last, captured.captured);
  nothing_before = parts.capture->Now();
  if (frames == 1) {
    const std::lock_guard lock(showing);
    first_shown = nothing_before;
  }
  Publish(described);
}

/// A source that froze or got lost: the overlay goes, with the reason.
void IntraoperativeWorker::Implementation::WatchSource() {
  const SourceState source = parts.capture->State();
  if (source.kind != source_kind) {
    source_kind = source.kind;
    Say(source.Usable() ? "source running" : "source lost", {{"message", source.message}});
  }
  const auto shown = Latest();
  if (!shown || (source.Usable() && shown->said_number == said_number &&
                 shown->recording_problem == recording_problem))
    return;
  auto out = std::make_shared<IntraoperativeSnapshot>(*shown);
  out->source = source;
  out->said = said;
  out->said_number = said_number;
  Gate(source, out.get());
  SayRecording(out.get());
  Publish(out);
}

std::shared_ptr<const IntraoperativeSnapshot> IntraoperativeWorker::Implementation::Current(
    Clock::time_point now) {
  const auto registered_one = Latest();
  if (!registered_one || !registered_one->stopped.empty()) return registered_one;
  const std::lock_guard lock(showing);
  if (!IsBehind(*registered_one, now)) return registered_one;
  const auto newest = parts.capture->Newest();  // there is one: it waits
  if (behind && behind_after == registered_one && behind->captured == newest->captured)
    return behind;
  auto out = std::make_shared<IntraoperativeSnapshot>(*registered_one);
  out->frame = Unregistered(*newest);
  out->captured = newest->captured;
  out->source = parts.capture->State();
  out->registered_fps = 0.0;
  out->gate = GateState::Off;
  const bool is_slow =
      IsBehindReason(registered_one->reason) && Seconds(now - registered_one->captured) < kStuck_s;
  out->reason = !out->source.Usable() && !out->source.message.empty() ? out->source.message
                : is_slow                                             ? registered_one->reason
                                                                      : kBehindReason;
  behind_after = registered_one;
  behind = out;
  return out;
}

/// One look at what came: decisions first, then the newest picture.
void IntraoperativeWorker::Implementation::Round() {
  const auto captured = parts.capture->Take(kLook_s);
  std::deque<Posted> decisions;
  {
    const std::lock_guard lock(mutex);
    decisions.swap(posted);
  }
  for (auto& [decision, asked] : decisions) CarryOut(std::move(decision), asked);
  SayNotes();
  if (captured) {
    if (source_kind != SourceState::Kind::Running) WatchSource();
    Register(*captured);
    last_captured = captured;
    return;
  }
  WatchSource();
  // Decisions are answered and shown while no picture comes, too.
  if (decisions.empty() || frames == 0) return;
  if (source_kind ==
      SourceState::Kind::Ended) {  // nor will one come: the model settles on the last
    for (int look = 0; look < kSettle; ++look) Register(*last_captured);
    return;
  }
  const auto shown = Latest();
  if (shown) Publish(Describe(shown->frame, last, shown->captured));
}

/// Registering threw: no one knows what solver and tracker hold now, so nothing is registered or
/// decided any more. The picture stays live and the state is the last whole one.
void IntraoperativeWorker::Implementation::GoOnWithout(const std::string& why) {
  stopped = why;
  Say(kRegistrationStopped, {{"reason", why}});
  while (!Stopped()) {
    SayNotes();
    const auto captured = parts.capture->Take(kLook_s);
    const auto shown = Latest();
    auto out = shown ? std::make_shared<IntraoperativeSnapshot>(*shown)
                     : std::make_shared<IntraoperativeSnapshot>();
    if (captured) {
      out->frame = Unregistered(*captured);
      out->captured = captured->captured;
    } else if (shown && shown->stopped == why && shown->recording_problem == recording_problem) {
      continue;
    }
    out->source = parts.capture->State();
    Gate(out->source, out.get());
    SayRecording(out.get());
    out->recording = false;  // of pictures that are not registered
    Publish(out);
  }
}

void IntraoperativeWorker::Implementation::Run() {
  std::string why;
  try {
    while (!Stopped()) Round();
  } catch (const std::exception& error) {
    why = *error.what() ? error.what() : "an error without a name";
  } catch (...) {
    why = "an error without a name";
  }
  try {
    if (!why.empty()) GoOnWithout(why);
  } catch (...) {  // not even that: the recording is completed all the same
  }
  SayNotes();  // of the last frame, and of what it took too long for
  if (frames > 0)
    WithSink([&](IntraoperativeSink& sink) { sink.Finish(parts.session->State(), last); });
  if (frames > 0) cuts = AppliedCuts(parts.session->State(), SurfaceTree(parts.uncut));
  parts.session.reset();  // here, where waiting for its last search holds nobody
}

IntraoperativeWorker::IntraoperativeWorker(Parts parts)
    : implementation_(std::make_unique<Implementation>(std::move(parts))) {
  implementation_->parts.session->KeepHistory();
  implementation_->thread = std::thread([this] { implementation_->Run(); });
}

IntraoperativeWorker::~IntraoperativeWorker() { Stop(); }

void IntraoperativeWorker::Stop() {
  {
    const std::lock_guard lock(implementation_->mutex);
    implementation_->stop = true;
  }
  const std::lock_guard joining(implementation_->joining);
  if (implementation_->thread.joinable()) implementation_->thread.join();
}

void IntraoperativeWorker::Post(IntraoperativeDecision decision) {
  const std::lock_guard lock(implementation_->mutex);
  implementation_->posted.push_back({std::move(decision), implementation_->latest_asks});
}

void IntraoperativeWorker::Note(const std::string& event, const JournalData& data) {
  implementation_->Note(event, data);
}

std::shared_ptr<const IntraoperativeSnapshot> IntraoperativeWorker::Latest() const {
  return implementation_->Latest();
}

std::shared_ptr<const IntraoperativeSnapshot> IntraoperativeWorker::Current(
    std::optional<std::chrono::steady_clock::time_point> now) {
  return implementation_->Current(now ? *now : implementation_->parts.capture->Now());
}

double IntraoperativeWorker::Time_s(std::chrono::steady_clock::time_point captured) const {
  return implementation_->Latest() ? Seconds(captured - implementation_->started) : 0.0;
}

const std::string& IntraoperativeWorker::RecordingProblem() const {
  return implementation_->recording_problem;
}

const std::optional<std::vector<CutRecord>>& IntraoperativeWorker::Cuts() const {
  return implementation_->cuts;
}

}  // namespace kerf
