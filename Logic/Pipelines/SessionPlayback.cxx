#include "Pipelines/SessionPlayback.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <mutex>
#include <thread>

#include "CaseIO/JournalRead.h"
#include "Core/Errors.h"
#include "Pipelines/CasePlan.h"
#include "Pipelines/PointSpool.h"
#include "Pipelines/SessionRun.h"
#include "Session/SnapshotMaker.h"

namespace kerf {
namespace {

std::uint64_t PictureChecksum(const Frame& frame) {
  std::uint64_t hash = 1469598103934665603ull;  // FNV-1a over 64-bit words
  if (!frame.image) return hash;
  const auto& data = frame.image->data;
  for (std::size_t i = 0; i + sizeof hash <= data.size(); i += sizeof hash) {
    std::uint64_t word;
    std::memcpy(&word, data.data() + i, sizeof word);
    hash = (hash ^ word) * 1099511628211ull;
  }
  return hash;
}

/// All that is large in a snapshot, always in the same order.
template <class Snapshot, class F>
void ForAllPoints(Snapshot& snapshot, F f) {
  f(snapshot.organ.points);
  for (auto& part : snapshot.structures) f(part.surface.points);
  for (auto* lines : {&snapshot.applied_lines, &snapshot.proposed_lines, &snapshot.planned_lines})
    for (auto& line : *lines) f(line);
}

/// Triangles that stay the same from cut to cut.
struct Topology {
  Triangles organ;
  std::vector<std::uint8_t> cut_face;
  std::vector<Triangles> structures;
};

bool Fits(const Topology& topology, const IntraoperativeSnapshot& snapshot) {
  const auto same = [](const Triangles& a, const Triangles& b) {
    return a.rows() == b.rows() && a == b;
  };
  if (!same(topology.organ, snapshot.organ.triangles) ||
      topology.cut_face != snapshot.organ_cut_face ||
      topology.structures.size() != snapshot.structures.size())
    return false;
  for (std::size_t i = 0; i < topology.structures.size(); ++i)
    if (!same(topology.structures[i], snapshot.structures[i].surface.triangles)) return false;
  return true;
}

/// One frame as it is kept.
struct Kept {
  IntraoperativeSnapshot rest;  ///< without points, triangles and picture
  std::shared_ptr<const Topology> topology;
  std::vector<PointSpool::Place> points;
  std::uint64_t picture = 0;
};

std::string Words(const JournalEntry& entry) {
  if (const auto cut = entry.Number("cut"))
    return fmt::format("{}: cut {}", entry.event, static_cast<int>(*cut) + 1);
  if (const std::string* why = entry.Text("reason")) return entry.event + ": " + *why;
  if (const std::string* why = entry.Text("message")) return why->empty() ? entry.event : *why;
  return entry.event;
}

std::optional<PlaybackEvent::Kind> KindOf(const std::string& event) {
  using Kind = PlaybackEvent::Kind;
  if (event == "cut proposed" || event == "cut applied" || event == "cut refused") return Kind::Cut;
  for (const char* mark : {"mark", "snapshot", "clamp closed", "clamp opened"})
    if (event == mark) return Kind::Mark;
  if (event == "source lost" || event == "source running" || event == "confirmation needed" ||
      event == "registration behind" || event == "registration caught up" ||
      event == kRegistrationStopped)
    return Kind::Loss;
  for (const char* decision : {"cut accepted", "cut rejected", "undone", "cut drawn", "cuts wait",
                               "cuts automatic", "registration confirmed"})
    if (event == decision) return Kind::Decision;
  return std::nullopt;
}

}  // namespace

struct SessionPlayback::Shared {
  explicit Shared(const SessionFolder& recorded)
      : session(recorded),
        run(recorded, recorded.case_folder),
        frames(run.FrameCount() + run.DecidedAfterLast()),
        maker(run.Uncut(), ReadCasePlan(recorded.case_folder, run.Uncut())) {}

  /// Number of the recorded frame whose picture is shown: the last one stays for what was decided
  /// after it.
  int Recorded(int frame) const { return std::clamp(frame, 0, run.FrameCount() - 1); }
  double TimeOf_s(int frame) const { return run.Frames()[Recorded(frame)].time_s; }

  SessionFolder session;
  SessionRun run;  ///< the thread's own, but for what never changes
  int frames;      ///< those registered, and one more where something was decided after the last
  SnapshotMaker maker;
  PointSpool spool;
  std::vector<PlaybackEvent> events;
  std::vector<char> unconfirmed;  ///< per frame: shown off until the surgeon confirmed

  mutable std::mutex mutex;
  std::vector<std::shared_ptr<const Kept>> kept;
  std::string problem;
  bool stop = false;
  std::thread thread;

  void ReadEvents();
  void Run();
  std::shared_ptr<const Kept> Keep(const SessionRun::Step& step);
  std::shared_ptr<const Topology> topology;  ///< the last one
};

void SessionPlayback::Shared::ReadEvents() {
  const int last = frames - 1;
  unconfirmed.assign(last + 1, 0);
  int off_from = -1;
  for (const JournalEntry& entry :
       ReadJournal((std::filesystem::path(session.root) / "journal.jsonl").string())) {
    const int frame = std::clamp(entry.frame, 0, last);
    if (entry.event == "confirmation needed") off_from = frame;
    if (entry.event == "registration confirmed" && off_from >= 0) {
      std::fill(unconfirmed.begin() + off_from, unconfirmed.begin() + frame, 1);
      off_from = -1;
    }
    const auto kind = KindOf(entry.event);
    if (!kind) continue;
    const PlaybackEvent event{*kind, frame, TimeOf_s(frame), Words(entry)};
    // A cut that grows is applied again and again: its first time counts.
    const bool again = *kind == PlaybackEvent::Kind::Cut &&
                       std::any_of(events.begin(), events.end(), [&](const PlaybackEvent& earlier) {
                         return earlier.words == event.words;
                       });
    if (!again) events.push_back(event);
  }
  if (off_from >= 0) std::fill(unconfirmed.begin() + off_from, unconfirmed.end(), 1);
}

std::shared_ptr<const Kept> SessionPlayback::Shared::Keep(const SessionRun::Step& step) {
  auto snapshot = maker.Make(step.frame, step.report, run.State());
  if (!topology || !Fits(*topology, *snapshot)) {
    auto fresh = std::make_shared<Topology>();
    fresh->organ = snapshot->organ.triangles;
    fresh->cut_face = snapshot->organ_cut_face;
    for (const auto& part : snapshot->structures)
      fresh->structures.push_back(part.surface.triangles);
    topology = std::move(fresh);
  }
  auto out = std::make_shared<Kept>();
  out->rest = *snapshot;
  out->topology = topology;
  out->picture = PictureChecksum(step.frame);
  out->rest.frame.image.reset();
  out->rest.organ.triangles.resize(0, 3);
  out->rest.organ_cut_face.clear();
  for (auto& part : out->rest.structures) part.surface.triangles.resize(0, 3);
  ForAllPoints(out->rest, [&](Points& points) {
    out->points.push_back(spool.Put(points));
    points.resize(0, 3);
  });
  if (unconfirmed[step.frame.index]) {
    out->rest.gate = GateState::Off;
    out->rest.reason = "not confirmed after a loss";
  }
  return out;
}

void SessionPlayback::Shared::Run() {
  std::string ended;
  try {
    std::optional<SessionRun::Step> last;
    const auto add = [&](const SessionRun::Step& step) {
      auto frame = Keep(step);
      const std::lock_guard lock(mutex);
      kept.push_back(std::move(frame));
      return !stop;
    };
    while (auto step = run.Next()) {
      last = std::move(step);
      if (!add(*last)) return;
    }
    if (last && run.DecidedAfterLast()) {
      last->frame.index = frames - 1;
      add(*last);
    }
  } catch (const std::exception& error) {
    ended = error.what();
  }
  const std::lock_guard lock(mutex);
  problem = ended;
}

SessionPlayback::SessionPlayback(const std::string& session_folder)
    : shared_(std::make_unique<Shared>(ReadSession(session_folder))),
      pictures_(std::make_unique<SessionSource>(shared_->session)) {
  shared_->ReadEvents();
  shared_->thread = std::thread([shared = shared_.get()] { shared->Run(); });
}

SessionPlayback::~SessionPlayback() {
  {
    const std::lock_guard lock(shared_->mutex);
    shared_->stop = true;
  }
  shared_->thread.join();
}

const SessionFolder& SessionPlayback::Session() const { return shared_->session; }
const CameraModel& SessionPlayback::Camera() const { return shared_->run.Camera(); }
const std::vector<PlaybackEvent>& SessionPlayback::Events() const { return shared_->events; }
int SessionPlayback::FrameCount() const { return shared_->frames; }

double SessionPlayback::TimeOf_s(int frame) const { return shared_->TimeOf_s(frame); }

int SessionPlayback::FrameAt(double time_s) const {
  const auto& frames = shared_->run.Frames();
  const auto after =
      std::upper_bound(frames.begin(), frames.begin() + shared_->run.FrameCount(), time_s,
                       [](double time, const RecordedFrame& frame) { return time < frame.time_s; });
  const int frame = std::max(0, static_cast<int>(after - frames.begin()) - 1);
  return frame == shared_->run.FrameCount() - 1 ? FrameCount() - 1 : frame;
}

int SessionPlayback::Ready() const {
  const std::lock_guard lock(shared_->mutex);
  return static_cast<int>(shared_->kept.size());
}

std::string SessionPlayback::Problem() const {
  const std::lock_guard lock(shared_->mutex);
  return shared_->problem;
}

std::shared_ptr<const IntraoperativeSnapshot> SessionPlayback::At(int frame) {
  std::shared_ptr<const Kept> kept;
  {
    const std::lock_guard lock(shared_->mutex);
    if (frame < 0 || frame >= static_cast<int>(shared_->kept.size()))
      throw InputError(shared_->session.root, "frame " + std::to_string(frame),
                       "has not been done again yet");
    kept = shared_->kept[frame];
  }
  auto out = std::make_shared<IntraoperativeSnapshot>(kept->rest);
  std::size_t next = 0;
  ForAllPoints(*out, [&](Points& points) { points = shared_->spool.Get(kept->points[next++]); });
  out->organ.triangles = kept->topology->organ;
  out->organ_cut_face = kept->topology->cut_face;
  for (std::size_t i = 0; i < out->structures.size(); ++i)
    out->structures[i].surface.triangles = kept->topology->structures[i];
  // Not every container finds its frames again: the picture must be the one that was registered.
  for (const bool by_reading : {false, true}) {
    pictures_->GoTo(shared_->Recorded(frame), by_reading);
    const auto picture = pictures_->Next();
    if (!picture || PictureChecksum(*picture) != kept->picture) continue;
    out->frame = *picture;
    out->frame.index = frame;
    return out;
  }
  throw InputError(shared_->session.root, "frame " + std::to_string(frame),
                   "its picture cannot be found again");
}

}  // namespace kerf
