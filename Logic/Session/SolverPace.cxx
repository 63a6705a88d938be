#include "Session/SolverPace.h"

#include <algorithm>
#include <cmath>

#include "Registration/MethodOptions.h"

namespace kerf {
namespace {

constexpr double kForget = 0.2;            // weight of the newest frame
constexpr int kFewest = 12;                // follows a slow motion on every mesh
constexpr int kPlenty = kFrameIterations;  // more is no limit
constexpr double kChange = 1.25;

}  // namespace

void SolverPace::Note(double total_ms, double solve_ms, int iterations) {
  if (!(deadline_ms_ > 0.0) || iterations <= 0) return;
  const double weight = known_ ? kForget : 1.0;
  other_ms_ += weight * (total_ms - solve_ms - other_ms_);
  iteration_ms_ += weight * (solve_ms / iterations - iteration_ms_);
  known_ = true;
  const double room = (deadline_ms_ - other_ms_) / std::max(iteration_ms_, 1e-6);
  const int wanted = static_cast<int>(std::clamp<double>(std::floor(room), kFewest, kPlenty));
  const int now = limit_ > 0 ? limit_ : kPlenty;
  const bool close = wanted < kChange * now && now < kChange * wanted;
  if (wanted < kPlenty && close) return;
  limit_ = wanted >= kPlenty ? 0 : wanted;
}

}  // namespace kerf
