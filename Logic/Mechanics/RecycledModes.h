#pragma once

#include <Eigen/Core>
#include <vector>

#include "Mechanics/ElementField.h"

namespace kerf {

/// The softest motions of the last frames' linear solves, as a third part of the preconditioner,
/// M⁻¹ += Σ w wᵀ/θ: a cut that grows opens in much the same way in the next frame, and the coarse
/// lattice cannot follow it before it has parted the support of its nodes. Ritz vectors w of M⁻¹H
/// with their values θ cost the iteration that found them nothing but the memory of it.
class RecycledModes {
 public:
  void Clear();
  /// Memory for so many vertices, written once: the first frame of a cut is no time to fetch pages.
  void Reserve(Index vertices);
  /// New vertices take part as those do that they stem from.
  void Apply(const ElementField& field, const TopologyChange& change,
             const ElementField::Patch& patch);

  /// Where M⁻¹ r of an iteration (from 0 on) belongs, by inner vertex; null if it is not needed.
  simd::F4* Record(int iteration, Index vertices);
  /// Takes the softest Ritz vectors. @param values, vectors of the tridiagonal matrix of the
  /// iteration, ascending; @param products rᵀM⁻¹r of the recorded iterations
  void Learn(const Workers& workers, Index vertices, const Eigen::VectorXd& values,
             const Eigen::MatrixXd& vectors, const std::vector<double>& products);

  /// wᵀr of a chunk of vertices.
  void DotChunk(Index chunk, Index begin, Index end, const simd::F4* residual);
  /// Amounts of all modes, of the sums of `chunks` chunks. @return their part of rᵀM⁻¹r
  double Correct(Index chunks);
  void ReserveChunks(Index chunks) { dots_.resize(chunks * kModes); }
  /// Their part of M⁻¹r at a vertex.
  __m128 At(Index inner) const {
    __m128 sum = _mm_setzero_ps();
    for (Index m = 0; m < count_; ++m)
      sum = _mm_add_ps(
          sum, _mm_mul_ps(_mm_set1_ps(amount_[m]), simd::Load(motion_[inner * kModes + m])));
    return sum;
  }

 private:
  /// Modes are few: each costs a dot product and an update in every iteration.
  static constexpr Index kModes = 4;
  Index count_ = 0, next_ = 0;     ///< modes in use; the one to be replaced when all are
  std::vector<simd::F4> motion_;   ///< by inner vertex and mode
  double stiffness_[kModes] = {};  ///< wᵀ H w when it was found
  float amount_[kModes] = {};
  std::vector<float> dots_;  ///< by chunk and mode
  std::vector<std::vector<simd::F4>> records_;
};

}  // namespace kerf
