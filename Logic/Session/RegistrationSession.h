#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "Core/Camera.h"
#include "Core/Frame.h"
#include "Registration/CutReview.h"
#include "Registration/ModelSearch.h"
#include "Registration/Reliability.h"
#include "Registration/Step.h"
#include "Session/FrameWatch.h"

namespace kerf {

/// Wall time of the stages of one frame, ms; the columns of timing.csv between capture and render.
struct StageTimes {
  double tracking_ms = 0, targets_ms = 0, detection_ms = 0, cutting_ms = 0, solve_ms = 0,
         structures_ms = 0;
  double Sum() const {
    return tracking_ms + targets_ms + detection_ms + cutting_ms + solve_ms + structures_ms;
  }
};

/// What one frame gave.
struct SessionFrame {
  int frame = 0;
  double time_s = 0.0;
  StepReport step;
  Reliability reliability;
  StageTimes times;
};

/// One intraoperative registration from its first frame on: owns state and engine, measures time
/// around the stages. The clock is only read for reports; results never depend on it.
/// Single-threaded use.
///
/// Where a call throws, the state is the one before it (Process: with KeepHistory only), so that
/// what is shown, written and exported is one whole model. Solvers and tracker may be half-way:
/// nothing more is to be registered or decided after that.
class RegistrationSession {
 public:
  /// @param camera with the accepted initial registration
  RegistrationSession(TetMesh mesh, std::vector<Structure> structures, CameraModel camera,
                      MethodOptions options, std::unique_ptr<FeatureTracker> tracker,
                      std::unique_ptr<OrganSegmenter> segmenter = nullptr);
  ~RegistrationSession();

  /// The first call detects and binds the features, every call registers.
  SessionFrame Process(const Frame& frame);

  // Decisions about cuts. They take effect between two frames; the same decisions between the same
  // frames give the same bits. Wrong numbers and cuts that are not in the state asked for change
  // nothing.

  /// From now on the model before each cut is kept, so that a cut can be taken back. Costs a copy
  /// of the model for each cut.
  void KeepHistory() { history_kept_ = true; }
  /// Proposals wait for AcceptCut, or are applied as they come.
  void HoldCuts(bool hold) { options_.hold_cuts = hold; }
  /// From the next frame on the solver takes at most so many iterations a frame; 0 = as many as
  /// ever (kFrameIterations).
  void LimitSolver(int iterations) {
    options_.solve.most_iterations =
        iterations > 0 ? std::min(iterations, kFrameIterations) : kFrameIterations;
  }
  /// Whether `frame` would wait for the search for better cuts. How long that takes is up to the
  /// machine: who acts on it writes down what was decided.
  bool SearchIsLate(int frame) const {
    return state_.probing.due_frame >= 0 && frame >= state_.probing.due_frame && !search_.Ready();
  }
  /// What the search found is not taken over, from the next frame on; or it is, when it is due.
  void HoldSearch(bool hold) { options_.hold_search = hold; }
  /// Cuts the model along a held proposal. @return what the cutter did
  CutReport AcceptCut(int cut);
  /// Forgets a proposal, or takes an applied cut out of the model; its evidence counts no more.
  /// @return false when there is no such cut, or no model before it was kept
  bool RejectCut(int cut);
  /// A cut by hand. @param line N×3 at rest, mm; @param depth_mm 0 = through the organ
  /// @return number of the cut, −1 where the line is too short
  int DrawCut(const Points& line, const Vec3& direction, double depth_mm, CutReport* report);
  struct Undone {
    std::string what;  ///< in words; empty when there was nothing
    int cut = -1;
    std::optional<CutReport> again{};  ///< what the cutter did for a cut that is back in the model
  };
  /// Takes back the last decision, or the last cut that was taken automatically.
  Undone Undo();

  const RegistrationState& State() const { return state_; }
  const CameraModel& Camera() const { return camera_; }
  const MethodOptions& Options() const { return options_; }

 private:
  class StageClock;
  struct Applied {  ///< one cut of the model, with the model before it
    int cut = -1;
    RegistrationState before;
  };
  struct Decision {
    enum class Kind { Taken, Accepted, Rejected, Drawn } kind = Kind::Taken;
    int cut = -1;
    ModelCut was;                ///< of a rejected cut
    Eigen::VectorXd refused_mm;  ///< before the rejection
  };
  /// Puts the state back when a decision throws half-way.
  class WholeOrBefore {
   public:
    explicit WholeOrBefore(RegistrationState* state);
    ~WholeOrBefore();
    WholeOrBefore(const WholeOrBefore&) = delete;
    WholeOrBefore& operator=(const WholeOrBefore&) = delete;

   private:
    RegistrationState* state_;
    RegistrationState before_;
    int thrown_;
  };
  Engine MakeEngine();
  void NoteCuts(const StepReport& step);

  CutReport ApplyNow(int cut);
  bool TakeOut(int cut);
  void DropSearch();
  bool InModel(int cut) const;
  bool Reject(int cut, Decision* decision);
  ModelCut* Cut(int cut);

  TetMesh mesh_;
  std::vector<Structure> structures_;
  CameraModel camera_;
  MethodOptions options_;
  std::unique_ptr<FeatureTracker> tracker_;
  std::unique_ptr<OrganSegmenter> segmenter_;
  Solvers solvers_;
  TetCutter cutter_;
  ModelSearch search_;
  std::unique_ptr<StageClock> clock_;
  RegistrationState state_;
  Index initially_tracked_ = 0;
  bool started_ = false;
  bool history_kept_ = false;
  FrameWatch watch_;
  RegistrationState before_;  ///< this frame's cuts; history only
  std::vector<Applied> applied_;
  std::vector<Decision> decisions_;
};

}  // namespace kerf
