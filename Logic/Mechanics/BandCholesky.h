#pragma once

#include <vector>

#include "Core/Types.h"
#include "Mechanics/Simd.h"

namespace kerf {

/// Cholesky factor of a symmetric positive semi-definite matrix with a banded profile, single
/// precision, in 8×8 blocks. Rows are scaled to a unit diagonal first; a pivot that has lost all
/// its digits drops its unknown (solution 0), so a singular matrix is no failure. For a few hundred
/// to a few thousand unknowns, ordered so that the profile is small.
class BandCholesky {
 public:
  /// All zero. @param first_block for each block row of 8 unknowns the first block column that is
  /// not zero
  /// @param room block rows that are likely to be appended
  void SetProfile(std::vector<Index> first_block, Index room = 0);
  /// Adds block rows at the end, zero but for what is added to them then; those before and their
  /// factor stay. @param first_block of all of them
  void Append(Index block_rows, Index first_block);
  Index Blocks() const { return static_cast<Index>(first_.size()); }
  /// A(row, column) += value, column ≤ row + 7 − row mod 8 (lower triangle; within a diagonal block
  /// both halves).
  void Add(Index row, Index column, float value) {
    const Index block = row / 8;
    matrix_[(8 * offset_[block] + column - 8 * first_[block])][row % 8] += value;
  }
  /// Adds a 3×3 block (row by row) of a symmetric matrix at (row, column) and, on the other side of
  /// the diagonal, its transpose. On the diagonal the block is symmetric.
  void AddBlock(Index row, Index column, const float block[9]);
  /// Factors the block rows from this one on; those before are factored.
  /// @return their smallest pivot relative to the diagonal, 0 if one was dropped; rows without a
  /// diagonal are not counted
  float Factor(Index from_block = 0);
  /// x = A⁻¹ x, array of 8·Blocks() floats.
  void Solve(float* x) const;

 private:
  void ListColumns();
  std::vector<Index> first_, offset_{0};  ///< per block row: first block column; start, in blocks
  std::vector<simd::F8> matrix_;          ///< [column][row in block], lower triangle by block rows
  std::vector<simd::F8> factor_;          ///< L likewise
  std::vector<simd::F8> inverse_;         ///< L_II⁻¹, [column][row in block]
  std::vector<simd::F8> inverse_transposed_;
  struct Below {
    Index row, block;  ///< block row; place of the block
  };
  std::vector<Below> below_;  ///< blocks below the diagonal, by block columns
  std::vector<Index> below_begin_;
  std::vector<float> scale_;
};

}  // namespace kerf
