#pragma once

#include <atomic>
#include <mutex>
#include <string>
#include <vector>

#include "Core/Progress.h"

namespace kerf {

/// Progress between a working thread and a window: the worker reports as often as it likes, the
/// window looks when it has time. Safe for concurrent use.
class JobProgress : public Progress {
 public:
  struct State {
    double fraction = 0.0;  ///< 0..1
    std::string what;
    std::vector<std::string> warnings;  ///< given since the last Take()
  };

  void Report(double fraction, const std::string& what) override;
  void Warn(const std::string& message) override;
  bool IsCancelled() const override { return cancelled_; }
  void Cancel() { cancelled_ = true; }
  State Take();

 private:
  std::atomic<bool> cancelled_{false};
  std::mutex mutex_;
  State state_;
};

}  // namespace kerf
