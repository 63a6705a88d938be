#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "CaseIO/ResultsFiles.h"
#include "Session/IntraoperativeDecision.h"
#include "Session/IntraoperativeSnapshot.h"
#include "Session/SnapshotMaker.h"

namespace kerf {

/// Where a session is recorded. Called from the worker's thread alone. Any InputError (a full disk)
/// ends the recording, never the session.
class IntraoperativeSink {
 public:
  virtual ~IntraoperativeSink() = default;
  /// Records a frame before it is registered. @return the frame as a replay will read it
  virtual Frame Record(const CapturedFrame& captured, int number, double time_s) = 0;
  virtual void Registered(const SessionFrame& frame, const RegistrationState& state) = 0;
  /// @param next_frame number of the frame that this comes before
  virtual void Say(double time_s, int next_frame, const std::string& event,
                   const JournalData& data) = 0;
  virtual void Finish(const RegistrationState& state, const SessionFrame& last) = 0;
};

/// The worker of a session: newest frame in, immutable snapshot out. Capture and display run apart
/// and are never waited for. Where registering throws, the session goes on without: the snapshot
/// says why, the picture stays live, what was recorded is completed by Stop().
class IntraoperativeWorker {
 public:
  struct Parts {
    std::unique_ptr<RegistrationSession> session;
    SurfaceMesh uncut;  ///< rest surface before any cut
    PlannedCut plan;
    std::shared_ptr<IntraoperativeCapture> capture;
    std::unique_ptr<IntraoperativeSink> sink;   ///< none: nothing is recorded
    std::string recording_problem;              ///< why there is none, where one was wanted
    std::vector<IntraoperativeDecision> first;  ///< before the second frame: cuts of a session that
                                                ///< is taken up again
    std::function<void()> on_snapshot;          ///< from the worker's thread; must be quick
    double deadline_ms = 40.0;  ///< of a frame: what takes longer limits the solver; 0 = none:
                                ///< all iterations, searches are waited for, no clock is asked
  };
  static constexpr double kLook_s = 0.05;  ///< how often a silent source is looked at
  explicit IntraoperativeWorker(Parts parts);
  ~IntraoperativeWorker();  ///< stops and completes the recording

  void Post(IntraoperativeDecision decision);
  /// A line for the journal (marks, snapshots).
  void Note(const std::string& event, const JournalData& data);
  /// Null before the first frame.
  std::shared_ptr<const IntraoperativeSnapshot> Latest() const;
  /// What is to be shown now: Latest(), or where registration does not keep up with the source the
  /// newest picture with the gate off: where a frame has waited for longer than 0.4 s. Said in the
  /// journal, too. Behind for longer than a second is a loss, to be confirmed as any other.
  /// @param now by the capture's clock; none: what that says
  std::shared_ptr<const IntraoperativeSnapshot> Current(
      std::optional<std::chrono::steady_clock::time_point> now = {});
  /// Since the session's first picture, s; 0 before that is registered.
  double Time_s(std::chrono::steady_clock::time_point captured) const;
  /// Ends after the frame in work; the recording is complete when this returns.
  void Stop();
  /// Why recording ended early, empty where all was written. Only after Stop().
  const std::string& RecordingProblem() const;
  /// Applied in the last state, recorded or not; none where no frame was registered. After Stop().
  const std::optional<std::vector<CutRecord>>& Cuts() const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace kerf
