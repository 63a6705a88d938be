#include "Session/JobProgress.h"

namespace kerf {

void JobProgress::Report(double fraction, const std::string& what) {
  const std::lock_guard<std::mutex> lock(mutex_);
  state_.fraction = fraction;
  state_.what = what;
}

void JobProgress::Warn(const std::string& message) {
  const std::lock_guard<std::mutex> lock(mutex_);
  state_.warnings.push_back(message);
}

JobProgress::State JobProgress::Take() {
  const std::lock_guard<std::mutex> lock(mutex_);
  State taken = state_;
  state_.warnings.clear();
  return taken;
}

}  // namespace kerf
