#pragma once

#include <algorithm>
#include <chrono>
#include <deque>

namespace kerf {

/// How many a second there were lately: the intervals of the last second, not the events in it, of
/// which five a second have six where both ends count.
class RateMeter {
 public:
  using Clock = std::chrono::steady_clock;

  void Add(Clock::time_point at) {
    at_.push_back(at);
    while (at_.size() > 2 && at - at_[1] >= std::chrono::seconds(1)) at_.pop_front();
  }
  void Clear() { at_.clear(); }
  /// Before the second event 0; in a silence what it leaves possible.
  double PerSecond(Clock::time_point now) const {
    if (at_.size() < 2) return 0.0;
    const auto seconds = [](Clock::duration d) {
      return std::max(1e-3, std::chrono::duration<double>(d).count());
    };
    const double rate = static_cast<double>(at_.size() - 1) / seconds(at_.back() - at_.front());
    return std::min(rate, 1.0 / seconds(now - at_.back()));
  }

 private:
  std::deque<Clock::time_point> at_;
};

}  // namespace kerf
