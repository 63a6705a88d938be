#pragma once

#include <chrono>

#include "Session/RegistrationSession.h"

namespace kerf {

/// Wall time of the stages of one frame.
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
  void Wait() override { Stop(); }
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

}  // namespace kerf
