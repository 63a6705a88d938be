#pragma once

#include "Mechanics/CoarseSpace.h"

namespace kerf {

/// M⁻¹ = D⁻¹ + P (PᵀKP)⁻¹ Pᵀ: the inverted 3×3 blocks of the diagonal and a coarse level. K is the
/// warped stiffness at the rotations of the last refresh plus loads and anchors; it may lag behind
/// the Hessian, which costs iterations, not accuracy.
class TwoLevelPreconditioner {
 public:
  void Reset(const Workers& workers, const std::vector<Vec3>& rest, const ElementField& field);
  /// Following a change of topology takes two steps: vertices and the diagonal, then the coarse
  /// level, for which there is time until UpdateCoarse.
  void FollowVertices(const Workers& workers, const std::vector<Vec3>& rest,
                      const ElementField& field, const ElementField::Patch& patch);
  void FollowCoarse(const Workers& workers, const ElementField& field,
                    const ElementField::Patch& patch);
  /// Inverts blocks of the diagonal that are out of date.
  void UpdateDiagonal(const Workers& workers, const ElementField& field, const FeatureLoads& loads);
  /// Loads or anchors may have changed: factors again if they differ enough from those factored (or
  /// after a refresh). All of the diagonal is out of date then; Smooth goes on with the old one, so
  /// it may be called meanwhile.
  void UpdateCoarse(const Workers& workers, const ElementField& field, const FeatureLoads& loads,
                    const std::vector<float>& anchor);

  /// D⁻¹ r at a vertex.
  __m128 Smooth(Index inner, __m128 r) const {
    const Inverse& inverse = inverse_[inner];
    const __m128 x = _mm_shuffle_ps(r, r, 0x00), y = _mm_shuffle_ps(r, r, 0x55),
                 z = _mm_shuffle_ps(r, r, 0xAA);
    return _mm_add_ps(
        _mm_mul_ps(simd::Load(inverse.x), x),
        _mm_add_ps(_mm_mul_ps(simd::Load(inverse.y), y), _mm_mul_ps(simd::Load(inverse.z), z)));
  }
  Index FunctionCount() const { return coarse_.FunctionCount(); }
  /// sums += Pᵀ r of one vertex
  void Restrict(Index inner, __m128 r, simd::F4* sums) const {
    const CoarseSpace::Row& row = coarse_.At(inner);
    for (int k = 0; k < 4; ++k) {
      simd::F4* sum = sums + row.function[k];
      simd::Store(sum, _mm_add_ps(simd::Load(*sum), _mm_mul_ps(_mm_set1_ps(row.weight[k]), r)));
    }
  }
  void SolveCoarse(simd::F4* sums) const { coarse_.Solve(sums); }
  /// P c at one vertex
  __m128 Prolong(Index inner, const simd::F4* c) const {
    const CoarseSpace::Row& row = coarse_.At(inner);
    __m128 sum = _mm_mul_ps(_mm_set1_ps(row.weight[0]), simd::Load(c[row.function[0]]));
    for (int k = 1; k < 4; ++k)
      sum = _mm_add_ps(sum, _mm_mul_ps(_mm_set1_ps(row.weight[k]), simd::Load(c[row.function[k]])));
    return sum;
  }

 private:
  struct Inverse {
    simd::F4 x, y, z;  ///< columns
  };
  CoarseSpace coarse_;
  void RefreshDiagonal(const ElementField& field, Index chunk);
  /// Elastic part by chunk and chunk vertex: xx yy zz yz xz xy 0 0.
  std::vector<std::vector<simd::F8>> diagonal_;
  std::vector<Inverse> inverse_;
  std::vector<float> factored_anchor_;  ///< by inner vertex
  std::vector<float> factored_;  ///< likewise, with the loads' stiffness, copies' at their origin
  std::vector<Index> origin_;    ///< by inner vertex: what it is a copy of, since the reset
  std::vector<Index> diagonal_stale_;  ///< chunks
  bool all_stale_ = true;
  bool was_cut_ = false;                                             ///< since the last update
  CoarseSpace::Change coarse_change_ = CoarseSpace::Change::kOther;  ///< since it was factored
};

}  // namespace kerf
