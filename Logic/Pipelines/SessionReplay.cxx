#include "Pipelines/SessionReplay.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "Adapters/OpenCv/CameraFile.h"
#include "Adapters/OpenCv/ImageSequence.h"
#include "Adapters/OpenCv/LucasKanadeTracker.h"
#include "Adapters/OpenCv/VideoSource.h"
#include "CaseIO/JournalRead.h"
#include "Core/Errors.h"
#include "Pipelines/OverlayRecorder.h"
#include "Pipelines/PlanPipeline.h"
#include "Pipelines/RegistrationParts.h"
#include "Pipelines/SessionRecorder.h"
#include "Session/IntraoperativeDecision.h"

namespace fs = std::filesystem;

namespace kerf {
namespace {

std::string In(const SessionFolder& session, const std::string& name) {
  return (fs::path(session.root) / name).string();
}

/// Decisions by the frame that they come before.
std::vector<std::pair<int, IntraoperativeDecision>> Decisions(const SessionFolder& session) {
  const std::string path = In(session, "journal.jsonl");
  std::vector<std::pair<int, IntraoperativeDecision>> out;
  for (const JournalEntry& entry : ReadJournal(path))
    if (auto decision = DecisionOf(entry, path)) out.push_back({entry.frame, std::move(*decision)});
  return out;
}

/// Recorded lines of states.csv; the last may be missing after a crash.
std::vector<std::string> States(const SessionFolder& session) {
  std::ifstream in(In(session, "states.csv"), std::ios::binary);
  std::vector<std::string> lines;
  std::string line;
  std::getline(in, line);
  while (std::getline(in, line) && !in.eof()) lines.push_back(line);
  return lines;
}

}  // namespace

SessionSource::SessionSource(const SessionFolder& session)
    : session_(session), frames_(ReadRecordedFrames(session.root)) {
  if (frames_.empty()) throw InputError(In(session, "frames.csv"), "", "no frame was recorded");
  if (!session.source.empty()) {
    video_ = OpenVideo(In(session, session.source));
    width_ = video_->Width();
    height_ = video_->Height();
  } else if (const auto first = ReadImageFile(In(session, "frames/000000.jpg"))) {
    width_ = first->width;
    height_ = first->height;
  } else {
    throw InputError(In(session, "frames/000000.jpg"), "", "cannot be read");
  }
}

SessionSource::~SessionSource() = default;
int SessionSource::Width() const { return width_; }
int SessionSource::Height() const { return height_; }
double SessionSource::FramesPerSecond() const { return session_.frames_per_second; }

std::optional<Frame> SessionSource::Next() {
  if (next_ >= frames_.size()) return std::nullopt;
  const RecordedFrame& recorded = frames_[next_];
  Frame frame;
  if (video_) {
    do {
      std::optional<Frame> read = video_->Next();
      if (!read)
        throw InputError(In(session_, session_.source),
                         "frame " + std::to_string(recorded.source_frame),
                         "is missing: this is not the video that was recorded");
      frame = std::move(*read);
    } while (frame.index < recorded.source_frame);
  } else {
    const std::string path = In(session_, fmt::format("frames/{:06d}.jpg", recorded.number));
    std::optional<Image> image = ReadImageFile(path);
    if (!image) throw InputError(path, "", "cannot be read");
    frame.image = std::make_shared<const Image>(std::move(*image));
  }
  frame.index = recorded.number;
  frame.time_s = recorded.time_s;
  ++next_;
  return frame;
}

ReplayResult ReplaySession(const ReplayRequest& request, Progress& progress) {
  const SessionFolder recorded = ReadSession(request.study);
  if (request.tracks || request.tetrahedra || request.given.size() > request.given.count("case") ||
      request.labels != ReplayRequest::Labels::Automatic)
    throw UsageError(
        "a session is repeated as it ran: no options of the method, no --tracks, "
        "--tetrahedra or --labels");
  if (fs::exists(request.results) && fs::equivalent(request.results, recorded.root))
    throw UsageError("--output is the session itself: choose another folder");
  PlannedCase planned = ReadCase(request.case_folder.value_or(recorded.case_folder));
  const CameraModel camera = ReadCameraFile(In(recorded, "camera.yml"));
  SessionSource source(recorded);
  const auto decisions = Decisions(recorded);
  const auto states = States(recorded);

  ResultsWriter results(request.results, camera, planned.organ_surface);
  Journal& journal = results.GetJournal();
  journal.Write(0.0, 0, "start",
                {{"program", "kerf"},
                 {"version", KERF_VERSION},
                 {"baseline", KERF_BASELINE},
                 {"session", fs::path(recorded.root).filename().string()},
                 {"notice", "research use, not a medical device"}});
  std::unique_ptr<OverlayRecorder> overlay;
  if (request.render)
    overlay = OverlayRecorder::Make(request.results, camera, source.FramesPerSecond(), progress);

  MethodOptions method;  // a live session runs Kerf's method
  method.hold_cuts = recorded.hold_cuts;
  method.wanted_features = recorded.wanted_features;
  RegistrationSession session(std::move(planned.mesh), std::move(planned.structures), camera,
                              method, MakeFeatureTracker({}), MakeVideoOrganSegmenter());
  session.KeepHistory();
  ReplayResult result;
  std::optional<SessionFrame> last;
  std::vector<double> totals;
  std::size_t next = 0;
  const auto decide_before = [&](int frame) {
    for (; next < decisions.size() && decisions[next].first <= frame; ++next) {
      IntraoperativeDecision decision = decisions[next].second;
      Decide(&session, &decision);
      journal.Write(last ? last->time_s : 0.0, decisions[next].first, EventName(decision.kind),
                    ToJournal(decision));
    }
  };
  while (auto frame = source.Next()) {
    progress.ThrowIfCancelled();
    if (last) decide_before(frame->index);
    last = session.Process(*frame);
    if (overlay) {
      overlay->Add(*frame, *last, session.State(), &results);
      if (result.frames % std::max(1, source.FrameCount() / 3) == 0) overlay->KeepSnapshot();
    }
    results.AddFrame(*last, session.State(), 0.0, 0.0);
    if (static_cast<std::size_t>(result.frames) < states.size() &&
        StateLine(*last, session.State()) != states[result.frames])
      throw InputError(In(recorded, "states.csv"), "frame " + std::to_string(last->frame),
                       "the replay gives another model: another version, or files that changed");
    totals.push_back(last->times.Sum());
    ++result.frames;
    progress.Report(double(result.frames) / source.FrameCount(),
                    fmt::format("frame {} of {}", result.frames, source.FrameCount()));
  }
  decide_before(source.FrameCount());
  results.WriteMeshes(*last, session.State());
  results.Finish(session.State());
  result.cuts = static_cast<int>(results.Cuts().size());
  result.final_gate = last->reliability.state;
  result.final_reason = last->reliability.reason;
  std::sort(totals.begin(), totals.end());
  result.median_ms = totals[totals.size() / 2];
  result.p99_ms = totals[std::min(totals.size() - 1, totals.size() * 99 / 100)];
  journal.Write(last->time_s, last->frame, "end",
                {{"frames", result.frames},
                 {"cuts", result.cuts},
                 {"checksums equal", int(std::min<std::size_t>(states.size(), result.frames))}});
  if (overlay) overlay->Finish();
  SessionFolder out = recorded;
  out.root = request.results;
  WriteSessionReport(out, results, session.State());
  return result;
}

}  // namespace kerf
