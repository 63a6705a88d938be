#include "Pipelines/SessionReplay.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "Core/Errors.h"
#include "Pipelines/OverlayRecorder.h"
#include "Pipelines/SessionRecorder.h"
#include "Pipelines/SessionRun.h"

namespace fs = std::filesystem;

namespace kerf {

ReplayResult ReplaySession(const ReplayRequest& request, Progress& progress) {
  const SessionFolder recorded = ReadSession(request.study);
  if (request.tracks || request.tetrahedra || request.given.size() > request.given.count("case") ||
      request.labels != ReplayRequest::Labels::Automatic)
    throw UsageError(
        "a session is repeated as it ran: no options of the method, no --tracks, "
        "--tetrahedra or --labels");
  if (fs::exists(request.results) && fs::equivalent(request.results, recorded.root))
    throw UsageError("--output is the session itself: choose another folder");
  SessionRun run(recorded, request.case_folder.value_or(recorded.case_folder));

  ResultsWriter results(request.results, run.Camera(), run.Uncut());
  Journal& journal = results.GetJournal();
  journal.Write(0.0, 0, "start",
                {{"program", "kerf"},
                 {"version", KERF_VERSION},
                 {"baseline", KERF_BASELINE},
                 {"session", fs::path(recorded.root).filename().string()},
                 {"notice", "research use, not a medical device"}});
  const std::unique_ptr<OverlayRecorder> overlay =
      OverlayRecorder::Make(request, run.Camera(), run.FramesPerSecond(), progress);
  ReplayResult result;
  std::optional<SessionFrame> last;
  std::vector<double> totals;
  run.on_decision = [&](int frame, const IntraoperativeDecision& decision,
                        const DecisionOutcome& outcome) {
    for (const auto& [event, data] : JournalLines(decision, outcome, run.State()))
      journal.Write(last ? last->time_s : 0.0, frame, event, data);
  };
  while (const auto step = run.Next()) {
    progress.ThrowIfCancelled();
    last = step->report;
    if (overlay)
      overlay->Add(step->frame, *last, run.State(),
                   result.frames % std::max(1, run.FrameCount() / 3) == 0, &results);
    results.AddFrame(*last, run.State(), 0.0, 0.0);
    totals.push_back(last->times.Sum());
    ++result.frames;
    progress.Report(double(result.frames) / run.FrameCount(),
                    fmt::format("frame {} of {}", result.frames, run.FrameCount()));
  }
  results.WriteMeshes(*last, run.State());
  results.Finish(run.State());
  result.cuts = static_cast<int>(results.Cuts().size());
  result.final_gate = last->reliability.state;
  result.final_reason = last->reliability.reason;
  std::sort(totals.begin(), totals.end());
  result.median_ms = totals[totals.size() / 2];
  result.p99_ms = totals[std::min(totals.size() - 1, totals.size() * 99 / 100)];
  journal.Write(
      last->time_s, last->frame, "end",
      {{"frames", result.frames}, {"cuts", result.cuts}, {"checksums equal", run.Checked()}});
  if (overlay) overlay->Finish();
  SessionFolder out = recorded;
  out.root = request.results;
  WriteSessionReport(out, results, run.State());
  return result;
}

}  // namespace kerf
