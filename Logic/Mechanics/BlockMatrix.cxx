#include "Mechanics/BlockMatrix.h"

#include <cmath>

namespace kerf {
namespace {
constexpr Index kRowChunk = 512;

double Dot(const Workers& workers, const VectorX& a, const VectorX& b) {
  return workers.SumChunks(
      static_cast<Index>(a.size()), 3 * kRowChunk, [&](Index begin, Index end) {
        return a.segment(begin, end - begin).dot(b.segment(begin, end - begin));
      });
}
}  // namespace

void BlockMatrix::SetPattern(const Tets& tets, Index vertex_count) {
  std::vector<std::vector<Index>> neighbors(vertex_count);
  for (Index v = 0; v < vertex_count; ++v) neighbors[v].push_back(v);
  for (Index t = 0; t < tets.rows(); ++t)
    for (int a = 0; a < 4; ++a)
      for (int b = 0; b < 4; ++b)
        if (a != b) neighbors[tets(t, a)].push_back(tets(t, b));
  begin_.assign(1, 0);
  column_.clear();
  for (auto& row : neighbors) {
    std::sort(row.begin(), row.end());
    row.erase(std::unique(row.begin(), row.end()), row.end());
    column_.insert(column_.end(), row.begin(), row.end());
    begin_.push_back(static_cast<Index>(column_.size()));
  }
  blocks_.assign(column_.size(), Mat3::Zero());
}

void BlockMatrix::SetZero() { std::fill(blocks_.begin(), blocks_.end(), Mat3::Zero()); }

Index BlockMatrix::Slot(Index row, Index column) const {
  const auto first = column_.begin() + begin_[row], last = column_.begin() + begin_[row + 1];
  const auto found = std::lower_bound(first, last, column);
  return found != last && *found == column ? static_cast<Index>(found - column_.begin()) : -1;
}

void BlockMatrix::Multiply(const Workers& workers, const VectorX& x, VectorX* y) const {
  y->resize(x.size());
  workers.ForChunks(Rows(), kRowChunk, [&](Index begin, Index end) {
    for (Index row = begin; row < end; ++row) {
      Vec3 sum = Vec3::Zero();
      for (Index s = begin_[row]; s < begin_[row + 1]; ++s)
        sum += blocks_[s] * x.segment<3>(3 * column_[s]);
      y->segment<3>(3 * row) = sum;
    }
  });
}

CgReport SolveCg(const Workers& workers, const BlockMatrix& A, const VectorX& b, bool jacobi,
                 double relative_tolerance, int max_iterations, VectorX* x) {
  CgReport report;
  const Index n = A.Rows();
  std::vector<Mat3> inverse(jacobi ? n : 0);
  for (Index v = 0; v < static_cast<Index>(inverse.size()); ++v) {
    inverse[v] = A.Diagonal(v).inverse();
    if (!inverse[v].allFinite()) inverse[v] = Mat3::Identity();
  }
  VectorX Ap, z;
  A.Multiply(workers, *x, &Ap);
  VectorX r = b - Ap;
  auto precondition = [&] {
    if (!jacobi) {
      z = r;
      return;
    }
    z.resize(r.size());
    for (Index v = 0; v < n; ++v) z.segment<3>(3 * v) = inverse[v] * r.segment<3>(3 * v);
  };
  precondition();
  VectorX p = z;
  const double scale = std::sqrt(Dot(workers, b, b));
  double rz = Dot(workers, r, z);
  const int limit = max_iterations > 0 ? max_iterations : 20 * std::max<Index>(n, 10);
  for (;; ++report.iterations) {
    const double residual = std::sqrt(Dot(workers, r, r));
    report.relative_residual = scale > 0.0 ? residual / scale : 0.0;
    report.converged = report.relative_residual <= relative_tolerance;
    if (report.converged || report.iterations >= limit) break;
    A.Multiply(workers, p, &Ap);
    const double curvature = Dot(workers, p, Ap);
    if (!(curvature > 0.0)) break;
    const double alpha = rz / curvature;
    *x += alpha * p;
    r -= alpha * Ap;
    precondition();
    const double rz_next = Dot(workers, r, z);
    p = z + (rz_next / rz) * p;
    rz = rz_next;
  }
  return report;
}

}  // namespace kerf
