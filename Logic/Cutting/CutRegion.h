#pragma once

#include <cstdint>
#include <vector>

#include "Core/TopologyChange.h"
#include "Cutting/SurfaceIndex.h"

namespace kerf {

/// Axis-parallel box, empty at first.
struct CutBox {
  Eigen::RowVector3d low = Eigen::RowVector3d::Constant(1e300);
  Eigen::RowVector3d high = Eigen::RowVector3d::Constant(-1e300);
  void Add(const Eigen::RowVector3d& p) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  void Grow(double margin) {
    low.array() -= margin;
    high.array() += margin;
  }
  bool Meets(const CutBox& o) const {
    return (low.array() <= o.high.array()).all() && (o.low.array() <= high.array()).all();
  }
};
CutBox BoxOf(const Points& points,
             const Eigen::Ref<const Eigen::Matrix<Index, 1, Eigen::Dynamic>>& row);

/// A number that tells a triangle from others by the bits of its corners.
std::uint64_t HashOfTriangle(const CutSurface& surface, Index triangle);

/// Triangle → its sheet: triangles of one sheet hang together through points with equal
/// coordinates. Numbered from 0 by their first triangles.
std::vector<int> SheetsOf(const CutSurface& surface);

/// The triangles that `take` chooses, with their points.
template <class Take>
CutSurface Part(const CutSurface& surface, Take take) {
  CutSurface part;
  std::vector<Index> number(surface.points.rows(), -1);
  std::vector<Index> used;
  part.triangles.resize(surface.triangles.rows(), 3);
  Index n = 0;
  for (Index t = 0; t < surface.triangles.rows(); ++t) {
    if (!take(t)) continue;
    for (int k = 0; k < 3; ++k) {
      const Index v = surface.triangles(t, k);
      if (number[v] < 0) {
        number[v] = static_cast<Index>(used.size());
        used.push_back(v);
      }
      part.triangles(n, k) = number[v];
    }
    ++n;
  }
  part.triangles.conservativeResize(n, 3);
  part.points.resize(used.size(), 3);
  for (std::size_t i = 0; i < used.size(); ++i) part.points.row(i) = surface.points.row(used[i]);
  return part;
}

double MeanEdge_mm(const TetMesh& mesh);

/// Tetrahedra in `region` whose box S comes into, or passes within the slack: those on both sides
/// of a face that lies on S but for rounding.
std::vector<Index> TetsNear(const TetMesh& mesh, const CutBox& region, const SurfaceIndex& index,
                            double slack_mm);

/// Tetrahedra that a patch is made of.
struct ChosenTets {
  std::vector<Index> tets;  ///< ascending
  std::vector<char> inner;  ///< vertices whose tetrahedra are all chosen
};
/// `core` tetrahedra and `rings` rings around them.
ChosenTets WithRings(const TetMesh& mesh, const std::vector<Index>& core, int rings);

}  // namespace kerf
