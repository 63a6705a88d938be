#include "Geometry/EmbedPoints.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <vector>

#include "Geometry/SurfaceTree.h"

namespace kerf {
namespace {

/// A weight this little below zero is rounding, not outside.
constexpr double kInsideTolerance = 1e-10;

/// Uniform grid over the mesh's box; each cell lists the tetrahedra whose boxes meet it
/// (ascending).
class TetGrid {
 public:
  explicit TetGrid(const TetMesh& mesh) : mesh_(mesh) {
    low_ = mesh.rest.colwise().minCoeff().transpose();
    const Vec3 high = mesh.rest.colwise().maxCoeff().transpose();
    const Vec3 extent = (high - low_).cwiseMax(1e-9);
    cell_mm_ = std::cbrt(extent.prod() / mesh.TetCount());
    for (int d = 0; d < 3; ++d)
      size_[d] = std::clamp(static_cast<int>(extent[d] / cell_mm_) + 1, 1, 512);
    step_ = extent.cwiseQuotient(size_.cast<double>());
    start_.assign(std::size_t(size_.prod()) + 1, 0);
    // Two passes: count, then fill.
    ForEachCell([&](std::size_t cell, Index) { ++start_[cell + 1]; });
    for (std::size_t c = 1; c < start_.size(); ++c) start_[c] += start_[c - 1];
    tets_.resize(start_.back());
    std::vector<std::size_t> next(start_.begin(), start_.end() - 1);
    ForEachCell([&](std::size_t cell, Index tet) { tets_[next[cell]++] = tet; });
  }

  /// The tetrahedron that holds p (of several the one where p is deepest, then the first); −1 where
  /// none does.
  Index Find(const Vec3& p, Vec4* weights) const {
    Eigen::Vector3i c;
    for (int d = 0; d < 3; ++d) {
      const double cell = std::floor((p[d] - low_[d]) / step_[d]);
      if (cell < -1.0 || cell > size_[d]) return -1;
      c[d] = std::clamp(static_cast<int>(cell), 0, size_[d] - 1);
    }
    const std::size_t cell = Cell(c[0], c[1], c[2]);
    Index best = -1;
    double deepest = -kInsideTolerance;
    for (std::size_t i = start_[cell]; i < start_[cell + 1]; ++i) {
      const Vec4 w = Weights(tets_[i], p);
      if (w.minCoeff() < deepest || (best >= 0 && w.minCoeff() == deepest)) continue;
      deepest = w.minCoeff();
      best = tets_[i];
      *weights = w;
    }
    return best;
  }

  Vec4 Weights(Index tet, const Vec3& p) const {
    const auto c = mesh_.tets.row(tet);
    return BarycentricWeights(p, mesh_.rest.row(c[0]).transpose(), mesh_.rest.row(c[1]).transpose(),
                              mesh_.rest.row(c[2]).transpose(), mesh_.rest.row(c[3]).transpose());
  }

 private:
  std::size_t Cell(int i, int j, int k) const {
    return (std::size_t(k) * size_[1] + j) * size_[0] + i;
  }
  template <typename Visit>
  void ForEachCell(Visit visit) const {
    for (Index t = 0; t < mesh_.TetCount(); ++t) {
      Vec3 low = mesh_.rest.row(mesh_.tets(t, 0)).transpose(), high = low;
      for (int k = 1; k < 4; ++k) {
        const Vec3 x = mesh_.rest.row(mesh_.tets(t, k)).transpose();
        low = low.cwiseMin(x);
        high = high.cwiseMax(x);
      }
      Eigen::Vector3i a, b;
      for (int d = 0; d < 3; ++d) {
        // A hair wider, so that a point on a cell's wall finds its tetrahedron from either side.
        const double slack = 1e-6 * step_[d];
        a[d] = std::clamp(static_cast<int>((low[d] - slack - low_[d]) / step_[d]), 0, size_[d] - 1);
        b[d] =
            std::clamp(static_cast<int>((high[d] + slack - low_[d]) / step_[d]), 0, size_[d] - 1);
      }
      for (int k = a[2]; k <= b[2]; ++k)
        for (int j = a[1]; j <= b[1]; ++j)
          for (int i = a[0]; i <= b[0]; ++i) visit(Cell(i, j, k), t);
    }
  }

  const TetMesh& mesh_;
  Vec3 low_, step_;
  double cell_mm_ = 1.0;
  Eigen::Vector3i size_;
  std::vector<std::size_t> start_;
  std::vector<Index> tets_;
};

}  // namespace

Embedding EmbedPoints(const TetMesh& mesh, const Points& points, EmbeddingReport* report) {
  if (mesh.TetCount() == 0) throw std::invalid_argument("EmbedPoints: the mesh has no tetrahedra");
  const TetGrid grid(mesh);
  EmbeddingReport counts;
  Embedding out;
  out.tet.resize(points.rows());
  out.weights.resize(points.rows(), 4);
  // The nearest tetrahedron of a point outside lies behind the nearest boundary face.
  std::unique_ptr<SurfaceTree> boundary;
  std::vector<Index> tet_of_face;
  for (Index i = 0; i < points.rows(); ++i) {
    const Vec3 p = points.row(i).transpose();
    Vec4 weights;
    Index tet = grid.Find(p, &weights);
    if (tet >= 0) {
      ++counts.inside;
    } else {
      if (!boundary) {
        SurfaceMesh faces;
        faces.points = mesh.rest;
        faces.triangles = BoundaryFaces(mesh.tets, &tet_of_face);
        boundary = std::make_unique<SurfaceTree>(faces);
      }
      const SurfaceHit hit = boundary->Closest(p);
      tet = tet_of_face[hit.triangle];
      weights = grid.Weights(tet, p);
      ++counts.outside;
      counts.largest_distance_mm = std::max(counts.largest_distance_mm, hit.distance_mm);
    }
    out.tet[i] = tet;
    out.weights.row(i) = weights.transpose();
  }
  if (report) *report = counts;
  return out;
}

}  // namespace kerf
