#pragma once

#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "Session/IntraoperativeCapture.h"
#include "Session/PlanDeviation.h"
#include "Session/RegistrationSession.h"

namespace kerf {

struct IntraoperativeSnapshot;

/// A cut as the timeline shows it.
struct CutItem {
  int number = 0;  ///< index in RegistrationState::cuts
  enum class State { Proposed, Applied, Rejected } state = State::Applied;
  int frame = 0;
  double time_s = 0.0;
  double confidence = 0.0, length_mm = 0.0;
  bool drawn = false;
  bool partial = false;  ///< applied, but the model could not be cut along all of it
  /// How it was before this cut came into the model: picture and model; null where it is not in it.
  std::shared_ptr<const IntraoperativeSnapshot> before;
};

/// Everything that is known about one registered frame; made by the worker, never changed. The
/// overlay drawn from it lies over the frame that is in it.
struct IntraoperativeSnapshot {
  Frame frame;  ///< numbered as recorded; −1: shown, but not registered
  std::chrono::steady_clock::time_point captured;

  SurfaceMesh organ;  ///< current, LPS, mm
  std::vector<std::uint8_t> organ_cut_face;
  struct Part {
    std::string name;
    SurfaceMesh surface;
  };
  std::vector<Part> structures;
  std::vector<Points> applied_lines, proposed_lines, planned_lines;  ///< on the moved organ, mm

  GateState gate = GateState::Off;  ///< what is shown; may be stricter than the registration's own
  std::string reason;
  bool needs_confirmation = false;  ///< after a loss: off until the surgeon confirms
  Reliability reliability;
  double margin_mm = std::numeric_limits<double>::quiet_NaN();  ///< tumour to cut, NaN: no cut
  double planned_margin_mm =
      std::numeric_limits<double>::quiet_NaN();  ///< as the plan wants it, NaN: no plan
  PlanDeviation deviation;  ///< cut faces to the planned sheet; NaN: no plan or no cut
  std::vector<CutItem> cuts;
  int tetrahedra = 0;

  StageTimes times;
  double registered_fps = 0.0;  ///< of the last second
  SourceState source;
  bool recording = false;
  std::string recording_problem;  ///< why it stopped, empty while all is well
  /// Why nothing is registered any more, empty while it runs. The picture goes on; the model is the
  /// last whole one, and the gate stays off.
  std::string stopped;
  std::string said;     ///< answer to the last decision
  int said_number = 0;  ///< grows with every answer
};

}  // namespace kerf
