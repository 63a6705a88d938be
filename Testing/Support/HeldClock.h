#pragma once

#include <chrono>
#include <memory>
#include <mutex>
#include <optional>

namespace kerf::testing {

/// The clock of a capture, stopped where a test wants it: what it notices after half a second of
/// silence is asked without waiting for as long. Copies are one clock.
class HeldClock {
 public:
  using Steady = std::chrono::steady_clock;
  Steady::time_point operator()() const {
    const std::lock_guard lock(held_->mutex);
    return held_->at.value_or(Steady::now());
  }
  /// Stops where the last new picture is `silence_s` old.
  /// @param state of the capture, asked for after the clock has stopped
  template <class State>
  void HoldSince(State state, double silence_s) {
    Hold((*this)());
    const auto by = std::chrono::duration<double>(silence_s - state().silence_s);
    Hold((*this)() + std::chrono::duration_cast<Steady::duration>(by));
  }
  void GoOn() {
    const std::lock_guard lock(held_->mutex);
    held_->at.reset();
  }

 private:
  void Hold(Steady::time_point at) {
    const std::lock_guard lock(held_->mutex);
    held_->at = at;
  }
  struct Held {
    std::mutex mutex;
    std::optional<Steady::time_point> at;
  };
  std::shared_ptr<Held> held_ = std::make_shared<Held>();
};

}  // namespace kerf::testing
