#pragma once

#include <memory>
#include <string>
#include <vector>

#include "Core/Camera.h"
#include "Core/Features.h"
#include "Cutting/TetCutter.h"
#include "Mechanics/ElasticSolver.h"
#include "Registration/MethodOptions.h"
#include "Registration/RegistrationState.h"

namespace kerf {

/// Stages of one frame, in order; the columns of timing.csv.
enum class Stage { Tracking, Targets, Detection, Cutting, Solve, Structures };

/// Told when a stage begins: the session measures time with it. Registration itself never looks at
/// a clock.
class StageObserver {
 public:
  virtual ~StageObserver() = default;
  virtual void Begin(Stage stage) = 0;
  /// Until the next stage begins, the frame waits for work in the background.
  virtual void Wait() = 0;
};

/// The solvers that follow one mesh.
struct Solvers {
  std::unique_ptr<ElasticSolver> organ;  ///< Eq. (5)
  std::unique_ptr<ElasticSolver> grips;  ///< GripFit; none: depth is gauged at rest alone
};

class ModelSearch;

/// The parts that a registration runs on. They hold caches only (image pyramids, factorizations).
struct Engine {
  FeatureTracker& tracker;
  Solvers& solvers;
  TetCutter& cutter;
  StageObserver* observer = nullptr;
  OrganSegmenter* segmenter = nullptr;  ///< none: the silhouette takes no part
  ModelSearch* search = nullptr;        ///< none: cuts stay as they were found
};

/// A growth of a cut in this frame.
struct CutEvent {
  int cut = 0;         ///< index in RegistrationState::cuts
  bool first = false;  ///< the cut was detected in this frame
  Vec3 point = Vec3::Zero();
  CutReport report;  ///< what the cutter did, or why it refused
};

constexpr double kOutlineOff_mm = 2.5;

struct StepReport {
  SolveReport solve;
  double divergence_mean_mm = 0.0;  ///< μ_∅ of the last iteration
  int outliers = 0;
  double leap_mm = 0.0;    ///< median step of the tracked features since the frame before
  int untangled = 0;       ///< vertices moved to keep elements well-shaped (Untangle.h)
  int outline_points = 0;  ///< where the organ's outline was found in the image; 0 = not looked for
  double outline_off = 0.0;  ///< share of them that lie off the model's outline by `kOutlineOff_mm`
  std::vector<CutEvent> cuts;
};

/// Everything before the first step: features of the first frame, bound to the registered model,
/// and their graph.
/// @param mesh, structures from planning; the pose in `camera` is the accepted initial registration
RegistrationState Initialize(const Frame& first, const CameraModel& camera, TetMesh mesh,
                             std::vector<Structure> structures, const MethodOptions& options,
                             Engine& engine);

/// One frame of the paper's Fig. 1. Values and options in, state changed, report out.
StepReport Step(const Frame& frame, const CameraModel& camera, const MethodOptions& options,
                Engine& engine, RegistrationState* state);

}  // namespace kerf
