#pragma once

#include <vector>

#include "Mechanics/Parallel.h"

namespace kerf {

using VectorX = Eigen::VectorXd;

/// Square sparse matrix of 3×3 blocks, N vertices, compressed rows with sorted columns; each row
/// has its diagonal.
class BlockMatrix {
 public:
  /// Blocks where two vertices share a tetrahedron, and every diagonal block. All zero.
  void SetPattern(const Tets& tets, Index vertex_count);
  void SetZero();
  Index Rows() const { return static_cast<Index>(begin_.size()) - 1; }
  /// Slot of block (row, column), −1 if outside the pattern.
  Index Slot(Index row, Index column) const;
  Index SlotCount() const { return static_cast<Index>(blocks_.size()); }
  Mat3& Block(Index slot) { return blocks_[slot]; }
  const Mat3& Block(Index slot) const { return blocks_[slot]; }
  /// Slots of a row are [RowBegin(row), RowBegin(row + 1)), columns ascending.
  Index RowBegin(Index row) const { return begin_[row]; }
  Index Column(Index slot) const { return column_[slot]; }
  const Mat3& Diagonal(Index row) const { return blocks_[Slot(row, row)]; }
  /// y = A x, both 3N.
  void Multiply(const Workers& workers, const VectorX& x, VectorX* y) const;

 private:
  std::vector<Index> begin_, column_;
  std::vector<Mat3> blocks_;
};

struct CgReport {
  int iterations = 0;
  double relative_residual = 0.0;  ///< ‖b − A x‖ / ‖b‖
  bool converged = false;          ///< false also where negative curvature ended the iteration
};

/// Conjugate gradient for A x = b, starting at *x. `jacobi`: precondition with the diagonal 3×3
/// blocks.
/// @param max_iterations 0 = no limit but 20·N
CgReport SolveCg(const Workers& workers, const BlockMatrix& A, const VectorX& b, bool jacobi,
                 double relative_tolerance, int max_iterations, VectorX* x);

}  // namespace kerf
