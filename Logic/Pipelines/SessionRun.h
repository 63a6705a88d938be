#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "Core/Camera.h"
#include "Core/SurfaceMesh.h"
#include "Pipelines/SessionSource.h"
#include "Session/IntraoperativeDecision.h"
#include "Session/RegistrationSession.h"

namespace kerf {

/// Does a recorded session again: the same frames, the same decisions between them, the same bits;
/// each frame's checksum is held against the recorded one. A session whose registration broke off
/// ends where that happened.
class SessionRun {
 public:
  /// @throws InputError naming file and element
  SessionRun(const SessionFolder& recorded, const std::string& case_folder);
  ~SessionRun();

  struct Step {
    Frame frame;
    SessionFrame report;
  };
  /// The next frame, after the decisions that came before it; none after the last one, when the
  /// decisions that came then are done too.
  /// @throws InputError where the checksum differs, naming the frame
  std::optional<Step> Next();

  /// Told of each decision when it was carried out, with the frame that it comes before and its
  /// outcome.
  std::function<void(int frame, const IntraoperativeDecision&, const DecisionOutcome&)> on_decision;

  const RegistrationState& State() const { return session_->State(); }
  const CameraModel& Camera() const { return session_->Camera(); }
  const SurfaceMesh& Uncut() const { return uncut_; }
  const std::vector<RecordedFrame>& Frames() const { return source_.Frames(); }
  int FrameCount() const { return frame_count_; }
  /// Whether something was decided after the last frame: State() shows it when Next() gave none.
  bool DecidedAfterLast() const;
  double FramesPerSecond() const { return source_.FramesPerSecond(); }
  /// Frames whose checksum was there and equal.
  int Checked() const { return checked_; }

 private:
  void DecideBefore(int frame);

  SessionFolder recorded_;
  SessionSource source_;
  SurfaceMesh uncut_;
  std::vector<std::pair<int, IntraoperativeDecision>> decisions_;  ///< by frame
  std::vector<std::string> states_;
  std::unique_ptr<RegistrationSession> session_;
  std::size_t next_decision_ = 0;
  int frame_count_ = 0, done_ = 0, checked_ = 0;
};

}  // namespace kerf
