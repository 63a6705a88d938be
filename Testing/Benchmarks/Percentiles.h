#pragma once

#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <ctime>
#include <string>
#include <vector>

namespace kerf::testing {

/// Wall and processor time (of all threads) since construction, ms.
class Stopwatch {
 public:
  Stopwatch() : wall_(std::chrono::steady_clock::now()), cpu_(CpuNow()) {}
  double Wall_ms() const {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - wall_)
        .count();
  }
  double Cpu_ms() const { return CpuNow() - cpu_; }

 private:
  static double CpuNow() {
    timespec t{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return 1e3 * static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_nsec);
  }
  std::chrono::steady_clock::time_point wall_;
  double cpu_;
};

inline double Percentile(std::vector<double> values, double fraction) {
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  const double at = fraction * static_cast<double>(values.size() - 1);
  return values[static_cast<std::size_t>(at + 0.5)];
}

/// Counters p50_ms, p99_ms of one benchmark (wall), and p50_cpu_ms (all threads: what a loaded
/// machine doesn't change).
inline void ReportPercentiles(benchmark::State& state, const std::vector<double>& wall_ms,
                              const std::vector<double>& cpu_ms) {
  state.counters["p50_ms"] = Percentile(wall_ms, 0.50);
  state.counters["p99_ms"] = Percentile(wall_ms, 0.99);
  state.counters["p50_cpu_ms"] = Percentile(cpu_ms, 0.50);
}

}  // namespace kerf::testing
