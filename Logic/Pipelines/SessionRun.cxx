#include "Pipelines/SessionRun.h"

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "Adapters/OpenCv/CameraFile.h"
#include "Adapters/OpenCv/LucasKanadeTracker.h"
#include "CaseIO/JournalRead.h"
#include "Core/Errors.h"
#include "Pipelines/PlanPipeline.h"
#include "Pipelines/RegistrationParts.h"
#include "Pipelines/SessionRecorder.h"

namespace kerf {
namespace {

std::string In(const SessionFolder& session, const std::string& name) {
  return (std::filesystem::path(session.root) / name).string();
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

SessionRun::SessionRun(const SessionFolder& recorded, const std::string& case_folder)
    : recorded_(recorded), source_(recorded), states_(States(recorded)) {
  frame_count_ = source_.FrameCount();
  const std::string journal = In(recorded, "journal.jsonl");
  for (const JournalEntry& entry : ReadJournal(journal)) {
    if (auto decision = DecisionOf(entry, journal))
      decisions_.push_back({entry.frame, std::move(*decision)});
    if (entry.event == kRegistrationStopped) frame_count_ = std::min(frame_count_, entry.frame);
  }
  if (frame_count_ == 0) throw InputError(journal, "", "no frame was registered");
  PlannedCase planned = ReadCase(case_folder);
  uncut_ = planned.organ_surface;
  MethodOptions method;  // a live session runs Kerf's method
  method.hold_cuts = recorded.hold_cuts;
  method.wanted_features = recorded.wanted_features;
  session_ =
      std::make_unique<RegistrationSession>(std::move(planned.mesh), std::move(planned.structures),
                                            ReadCameraFile(In(recorded, "camera.yml")), method,
                                            MakeFeatureTracker({}), MakeVideoOrganSegmenter());
  session_->KeepHistory();
}

SessionRun::~SessionRun() = default;

bool SessionRun::DecidedAfterLast() const {
  return !decisions_.empty() && decisions_.back().first >= frame_count_;
}

void SessionRun::DecideBefore(int frame) {
  for (; next_decision_ < decisions_.size() && decisions_[next_decision_].first <= frame;
       ++next_decision_) {
    auto [before, decision] = decisions_[next_decision_];
    const DecisionOutcome outcome = Decide(session_.get(), &decision);
    if (on_decision) on_decision(before, decision, outcome);
  }
}

std::optional<SessionRun::Step> SessionRun::Next() {
  if (done_ > 0) DecideBefore(done_);
  if (done_ >= frame_count_) return std::nullopt;
  const auto frame = source_.Next();
  Step step{*frame, session_->Process(*frame)};
  if (static_cast<std::size_t>(done_) < states_.size()) {
    if (StateLine(step.report, session_->State()) != states_[done_])
      throw InputError(In(recorded_, "states.csv"), "frame " + std::to_string(done_),
                       "the replay gives another model: another version, or files that changed");
    ++checked_;
  }
  ++done_;
  return step;
}

}  // namespace kerf
