#include "Session/IntraoperativeWorker.h"

#include <deque>
#include <mutex>
#include <thread>

#include "Core/Errors.h"
#include "Geometry/EmbedPoints.h"
#include "Registration/CutLine.h"
#include "Registration/CutView.h"
#include "Session/ModelView.h"

namespace kerf {
namespace {

using Clock = std::chrono::steady_clock;
constexpr double kLook_s = 0.1;           // how often a silent source is looked at
constexpr double kLossToConfirm_s = 1.0;  // off for longer than this: the surgeon confirms

double Seconds(Clock::duration d) { return std::chrono::duration<double>(d).count(); }

double Length_mm(const Points& line) {
  double sum = 0.0;
  for (Index i = 0; i + 1 < line.rows(); ++i) sum += (line.row(i + 1) - line.row(i)).norm();
  return sum;
}

}  // namespace

struct IntraoperativeWorker::Implementation {
  explicit Implementation(Parts given) : parts(std::move(given)), uncut(parts.uncut), view(uncut) {}

  Parts parts;
  SurfaceTree uncut;
  ModelView view;
  CutView cut_view;
  std::thread thread;

  mutable std::mutex mutex;
  bool stop = false;
  std::deque<IntraoperativeDecision> posted;
  std::deque<std::pair<std::string, JournalData>> notes;
  std::shared_ptr<const IntraoperativeSnapshot> latest;

  // The worker's own.
  int frames = 0;
  Clock::time_point started;
  double time_s = 0.0;
  std::deque<Clock::time_point> done_at;
  std::optional<Clock::time_point> off_since;
  bool needs_confirmation = false;
  SourceState::Kind source_kind = SourceState::Kind::Running;
  std::string recording_problem, said;
  int said_number = 0;
  SessionFrame last;
  std::vector<double> cut_times_s;
  struct BoundLines {  ///< planned and proposed lines in the mesh; remade when either changes
    std::string of;
    std::vector<Embedding> planned, proposed;
  } bound;

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

  void Run();
  void Register(const CapturedFrame& captured);
  void CarryOut(IntraoperativeDecision decision);
  void WatchSource();
  void Gate(const SourceState& source, IntraoperativeSnapshot* out);
  std::shared_ptr<IntraoperativeSnapshot> Describe(const Frame& frame, const SessionFrame& report,
                                                   Clock::time_point captured);
  void Lines(const RegistrationState& state, IntraoperativeSnapshot* out);
  void Publish(std::shared_ptr<const IntraoperativeSnapshot> snapshot) {
    {
      const std::lock_guard lock(mutex);
      latest = std::move(snapshot);
    }
    if (parts.on_snapshot) parts.on_snapshot();
  }
};

void IntraoperativeWorker::Implementation::CarryOut(IntraoperativeDecision decision) {
  if (frames == 0) return;  // there is no state to decide about yet
  const DecisionOutcome outcome = Decide(parts.session.get(), &decision);
  said = outcome.words;
  ++said_number;
  if (!outcome.done) return;
  if (decision.kind == IntraoperativeDecision::Kind::Confirm) {
    needs_confirmation = false;
    off_since.reset();
  }
  Say(EventName(decision.kind), ToJournal(decision));
}

void IntraoperativeWorker::Implementation::Lines(const RegistrationState& state,
                                                 IntraoperativeSnapshot* out) {
  cut_view.Update(state);
  out->margin_mm = cut_view.TumourMargin_mm();
  std::string of = std::to_string(state.mesh.TetCount());
  for (const ModelCut& cut : state.cuts)
    of += (cut.held ? " h" : " ") + std::to_string(cut.line.points.rows());
  if (bound.of != of) {
    bound = {of, {}, {}};
    for (const Points& line : parts.planned_lines)
      bound.planned.push_back(EmbedPoints(state.mesh, line));
    for (const ModelCut& cut : state.cuts) {
      if (!cut.held) continue;
      const Points line = LineOnSurface(cut.line, cut.view, uncut);
      if (line.rows() > 1) bound.proposed.push_back(EmbedPoints(state.mesh, line));
    }
  }
  const auto now = [&](const Embedding& line) {
    return line.Positions(state.positions, state.mesh.tets);
  };
  for (const Embedding& line : bound.planned) out->planned_lines.push_back(now(line));
  for (const Embedding& line : bound.proposed) out->proposed_lines.push_back(now(line));
  const auto& lips = cut_view.Lips();
  const auto& lip_cuts = cut_view.LipCuts();
  for (std::size_t i = 0; i < lips.size(); ++i)
    if (!state.cuts[lip_cuts[i]].held) out->applied_lines.push_back(lips[i]);
}

void IntraoperativeWorker::Implementation::Gate(const SourceState& source,
                                                IntraoperativeSnapshot* out) {
  const auto now = Clock::now();
  out->gate = out->reliability.state;
  out->reason = out->reliability.reason;
  if (!source.Usable()) {
    out->gate = GateState::Off;
    out->reason = source.message.empty() ? "no picture" : source.message;
  }
  if (out->gate != GateState::Off && !needs_confirmation) {
    off_since.reset();
    return;
  }
  if (!off_since) off_since = now;
  // A loss is never bridged: whether the model is right again is for the surgeon to say.
  if (!needs_confirmation && Seconds(now - *off_since) > kLossToConfirm_s) {
    needs_confirmation = true;
    Say("confirmation needed", {{"reason", out->reason}});
  }
  out->needs_confirmation = needs_confirmation;
  if (needs_confirmation && out->gate != GateState::Off) {
    out->gate = GateState::Off;
    out->reason = "the picture is back: check the registration and confirm";
  }
}

std::shared_ptr<IntraoperativeSnapshot> IntraoperativeWorker::Implementation::Describe(
    const Frame& frame, const SessionFrame& report, Clock::time_point captured) {
  const RegistrationState& state = parts.session->State();
  auto out = std::make_shared<IntraoperativeSnapshot>();
  out->frame = frame;
  out->captured = captured;
  const OrganView& organ = view.Update(state);
  out->organ = organ.current;
  out->organ_cut_face = organ.cut_face;
  for (const Structure& structure : state.structures)
    if (!structure.rest.Empty())
      out->structures.push_back({structure.name, CurrentSurface(structure, state)});
  Lines(state, out.get());
  out->reliability = report.reliability;
  out->times = report.times;
  out->tetrahedra = state.mesh.TetCount();
  cut_times_s.resize(state.cuts.size(), time_s);
  for (std::size_t i = 0; i < state.cuts.size(); ++i) {
    const ModelCut& cut = state.cuts[i];
    CutItem item;
    item.number = static_cast<int>(i);
    item.state = cut.rejected ? CutItem::State::Rejected
                 : cut.held   ? CutItem::State::Proposed
                              : CutItem::State::Applied;
    item.frame = cut.detected_frame;
    item.time_s = cut_times_s[i];
    item.confidence = cut.confidence;
    item.length_mm = Length_mm(cut.line.points);
    item.drawn = cut.drawn;
    out->cuts.push_back(item);
  }
  const auto now = Clock::now();
  done_at.push_back(now);
  while (Seconds(now - done_at.front()) > 1.0) done_at.pop_front();
  out->registered_fps = static_cast<double>(done_at.size());
  out->source = parts.capture->State();
  Gate(out->source, out.get());
  out->recording = parts.sink != nullptr;
  out->recording_problem = recording_problem;
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
  last = parts.session->Process(frame);
  ++frames;
  WithSink([&](IntraoperativeSink& sink) { sink.Registered(last, parts.session->State()); });
  if (frames == 1)
    for (const IntraoperativeDecision& decision : parts.first) CarryOut(decision);
  Publish(Describe(frame, last, captured.captured));
}

/// A source that froze or got lost: the overlay goes, with the reason.
void IntraoperativeWorker::Implementation::WatchSource() {
  const SourceState source = parts.capture->State();
  if (source.kind != source_kind) {
    source_kind = source.kind;
    Say(source.Usable() ? "source running" : "source lost", {{"message", source.message}});
  }
  std::shared_ptr<const IntraoperativeSnapshot> shown;
  {
    const std::lock_guard lock(mutex);
    shown = latest;
  }
  if (!shown || (source.Usable() && shown->said_number == said_number)) return;
  auto out = std::make_shared<IntraoperativeSnapshot>(*shown);
  out->source = source;
  out->said = said;
  out->said_number = said_number;
  Gate(source, out.get());
  Publish(out);
}

void IntraoperativeWorker::Implementation::Run() {
  while (!Stopped()) {
    const auto captured = parts.capture->Take(kLook_s);
    std::deque<IntraoperativeDecision> decisions;
    std::deque<std::pair<std::string, JournalData>> lines;
    {
      const std::lock_guard lock(mutex);
      decisions.swap(posted);
      lines.swap(notes);
    }
    for (auto& decision : decisions) CarryOut(std::move(decision));
    for (const auto& [event, data] : lines) Say(event, data);
    if (captured) {
      if (source_kind != SourceState::Kind::Running) WatchSource();
      Register(*captured);
    } else {
      WatchSource();
      // Decisions are answered and shown while no picture comes, too.
      if (!decisions.empty() && frames > 0) {
        std::shared_ptr<const IntraoperativeSnapshot> shown;
        {
          const std::lock_guard lock(mutex);
          shown = latest;
        }
        Publish(Describe(shown->frame, last, shown->captured));
      }
    }
  }
  if (frames > 0)
    WithSink([&](IntraoperativeSink& sink) { sink.Finish(parts.session->State(), last); });
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
  if (implementation_->thread.joinable()) implementation_->thread.join();
}

void IntraoperativeWorker::Post(IntraoperativeDecision decision) {
  const std::lock_guard lock(implementation_->mutex);
  implementation_->posted.push_back(std::move(decision));
}

void IntraoperativeWorker::Note(const std::string& event, const JournalData& data) {
  const std::lock_guard lock(implementation_->mutex);
  implementation_->notes.push_back({event, data});
}

std::shared_ptr<const IntraoperativeSnapshot> IntraoperativeWorker::Latest() const {
  const std::lock_guard lock(implementation_->mutex);
  return implementation_->latest;
}

}  // namespace kerf
