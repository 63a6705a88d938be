#pragma once

#include <memory>
#include <vector>

#include "Core/Camera.h"
#include "Core/Frame.h"
#include "Registration/Reliability.h"
#include "Registration/Step.h"

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
class RegistrationSession {
 public:
  /// @param camera with the accepted initial registration
  RegistrationSession(TetMesh mesh, std::vector<Structure> structures, CameraModel camera,
                      MethodOptions options, std::unique_ptr<FeatureTracker> tracker,
                      std::unique_ptr<OrganSegmenter> segmenter = nullptr);
  ~RegistrationSession();

  /// The first call detects and binds the features, every call registers.
  SessionFrame Process(const Frame& frame);
  const RegistrationState& State() const { return state_; }
  const CameraModel& Camera() const { return camera_; }
  const MethodOptions& Options() const { return options_; }

 private:
  class StageClock;
  TetMesh mesh_;
  std::vector<Structure> structures_;
  CameraModel camera_;
  MethodOptions options_;
  std::unique_ptr<FeatureTracker> tracker_;
  std::unique_ptr<OrganSegmenter> segmenter_;
  std::unique_ptr<ElasticSolver> solver_;
  TetCutter cutter_;
  std::unique_ptr<StageClock> clock_;
  RegistrationState state_;
  Index initially_tracked_ = 0;
  bool started_ = false;
};

}  // namespace kerf
