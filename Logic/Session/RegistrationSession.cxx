#include "Session/RegistrationSession.h"

#include <chrono>

namespace kerf {

class RegistrationSession::StageClock : public StageObserver {
 public:
  void Start() {
    times_ = {};
    running_ = nullptr;
  }
  void Begin(Stage stage) override {
    Stop();
    running_ = Column(stage);
    since_ = std::chrono::steady_clock::now();
  }
  StageTimes Finish() {
    Stop();
    return times_;
  }

 private:
  void Stop() {
    if (!running_) return;
    *running_ +=
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - since_)
            .count();
    running_ = nullptr;
  }
  double* Column(Stage stage) {
    switch (stage) {
      case Stage::Tracking:
        return &times_.tracking_ms;
      case Stage::Targets:
        return &times_.targets_ms;
      case Stage::Detection:
        return &times_.detection_ms;
      case Stage::Cutting:
        return &times_.cutting_ms;
      case Stage::Solve:
        return &times_.solve_ms;
      case Stage::Structures:
        return &times_.structures_ms;
    }
    return nullptr;
  }
  StageTimes times_;
  double* running_ = nullptr;
  std::chrono::steady_clock::time_point since_;
};

RegistrationSession::RegistrationSession(TetMesh mesh, std::vector<Structure> structures,
                                         CameraModel camera, MethodOptions options,
                                         std::unique_ptr<FeatureTracker> tracker,
                                         std::unique_ptr<OrganSegmenter> segmenter)
    : mesh_(std::move(mesh)),
      structures_(std::move(structures)),
      camera_(std::move(camera)),
      options_(std::move(options)),
      tracker_(std::move(tracker)),
      segmenter_(std::move(segmenter)),
      solver_(options_.method == Method::Reference ? MakeReferenceSolver() : MakeKerfSolver()),
      clock_(std::make_unique<StageClock>()) {
  options_.Validate();
}

RegistrationSession::~RegistrationSession() = default;

SessionFrame RegistrationSession::Process(const Frame& frame) {
  Engine engine{*tracker_, *solver_, cutter_, clock_.get(), segmenter_.get()};
  if (!started_) {
    state_ = Initialize(frame, camera_, std::move(mesh_), std::move(structures_), options_, engine);
    for (Index i = 0; i < state_.features.Size(); ++i)
      if (state_.features.status[i] == FeatureStatus::Tracked && state_.bound.on_surface[i])
        ++initially_tracked_;
    started_ = true;
  }
  SessionFrame out;
  out.frame = frame.index;
  out.time_s = frame.time_s;
  clock_->Start();
  out.step = Step(frame, camera_, options_, engine, &state_);
  out.times = clock_->Finish();
  out.reliability = AssessReliability(state_, camera_, initially_tracked_);
  return out;
}

}  // namespace kerf
