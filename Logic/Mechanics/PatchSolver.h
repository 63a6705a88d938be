#pragma once

#include <vector>

#include "Mechanics/FeatureLoads.h"
#include "Mechanics/TwoLevelPreconditioner.h"

namespace kerf {

/// Minimizes the energy over a few vertices while all others stay where they are. Around the tip of
/// a cut the rotations turn by more than one Newton step of the whole mesh gets right; a few steps
/// of the surroundings do, at a cost that follows their number.
class PatchSolver {
 public:
  /// What the whole problem says at the start, by inner vertex.
  struct Problem {
    const FeatureLoads& loads;  ///< linearized; taken as quadratic
    const std::vector<float>& anchor;
    const std::vector<double>& anchor_at;  ///< 3 per inner vertex
    const TwoLevelPreconditioner& preconditioner;
  };

  /// @param vertices inner numbers, ascending: the free ones; @param x inner positions, 3 per inner
  /// vertex, mm. Chunks of vertices that were moved are stale afterwards.
  void Solve(const std::vector<Index>& vertices, const Problem& problem, ElementField* field,
             std::vector<double>* x);

 private:
  struct Pull {
    Index free, load;  ///< load in pulled_
    float weight;
  };
  void Attach(const Problem& problem);
  /// force_ of springs and anchors at the start.
  void SetForce(const Problem& problem, const std::vector<double>& x);
  /// Springs' and anchors' part of H p at the free vertices, added to y.
  void AddOuterProduct(const Problem& problem, const std::vector<simd::F4>& p,
                       std::vector<simd::F4>* y);
  /// Linearizes at x_. @return energy, nJ, relative to that of no motion
  double Linearize(const Problem& problem);
  /// Conjugate gradient for step_. @return −gradient · step
  double SolveLinear(const Problem& problem);

  Index free_ = 0;
  ElementField::Excerpt excerpt_;
  std::vector<Pull> pulls_;
  std::vector<Index> pulled_;            ///< loads that pull at free vertices
  std::vector<simd::F4> pulled_values_;  ///< scratch, by pulled_
  std::vector<simd::F4> x_, local_;      ///< by excerpt vertex
  std::vector<simd::F4> start_, force_, outer_, residual_, direction_, step_;  ///< by free vertex
  std::vector<simd::F4> product_;
};

}  // namespace kerf
