#pragma once

namespace kerf {

/// How many iterations the solver may take so that a live frame keeps its deadline, from how long
/// the last frames took. The only place where time turns into a number of iterations; a session
/// writes the number to its journal, so that a replay needs no clock.
class SolverPace {
 public:
  /// @param deadline_ms for the work on one frame; 0 = none, never a limit
  explicit SolverPace(double deadline_ms) : deadline_ms_(deadline_ms) {}

  /// Notes one frame. @param solve_ms of `total_ms` in the solver's stage
  void Note(double total_ms, double solve_ms, int iterations);
  /// Limit for the next frame, 0 = none needed. Moves in steps of a quarter at least, so that a
  /// journal isn't filled with it; never below what follows a slow motion.
  int Limit() const { return limit_; }

 private:
  double deadline_ms_;
  double other_ms_ = 0.0, iteration_ms_ = 0.0;  ///< running means
  bool known_ = false;
  int limit_ = 0;
};

}  // namespace kerf
