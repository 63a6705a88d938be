#include "Cutting/CutRegion.h"

#include <algorithm>
#include <cstring>

#include "Cutting/DisjointSets.h"
#include "Cutting/SurfaceIndex.h"

namespace kerf {

CutBox BoxOf(const Points& points,
             const Eigen::Ref<const Eigen::Matrix<Index, 1, Eigen::Dynamic>>& row) {
  CutBox box;
  for (Index k = 0; k < row.size(); ++k) box.Add(points.row(row[k]));
  return box;
}

std::uint64_t HashOfTriangle(const CutSurface& surface, Index triangle) {
  std::uint64_t hash = 1469598103934665603u;
  for (int k = 0; k < 3; ++k)
    for (int axis = 0; axis < 3; ++axis) {
      const double x = surface.points(surface.triangles(triangle, k), axis);
      std::uint64_t bits;
      std::memcpy(&bits, &x, sizeof(bits));
      hash = (hash ^ bits) * 0x9E3779B97F4A7C15u;
      hash ^= hash >> 29;
    }
  return hash;
}

std::vector<int> SheetsOf(const CutSurface& surface) {
  const Index points = static_cast<Index>(surface.points.rows());
  DisjointSets joined(points);
  for (Index t = 0; t < surface.triangles.rows(); ++t)
    for (int k = 1; k < 3; ++k) joined.Join(surface.triangles(t, 0), surface.triangles(t, k));
  const auto one_sheet = [&] {
    for (Index t = 1; t < surface.triangles.rows(); ++t)
      if (joined.Find(surface.triangles(t, 0)) != joined.Find(surface.triangles(0, 0)))
        return false;
    return true;
  };
  if (!one_sheet()) {
    const std::vector<Index> equal = EqualPoints(surface.points);
    for (Index i = 0; i < points; ++i) joined.Join(i, equal[i]);
  }
  std::vector<int> number(points, -1), sheet(surface.triangles.rows());
  int sheets = 0;
  for (Index t = 0; t < surface.triangles.rows(); ++t) {
    int& n = number[joined.Find(surface.triangles(t, 0))];
    if (n < 0) n = sheets++;
    sheet[t] = n;
  }
  return sheet;
}

double MeanEdge_mm(const TetMesh& mesh) {
  double sum = 0;
  Index n = 0;
  const Index stride = std::max<Index>(1, mesh.TetCount() / 500);
  for (Index t = 0; t < mesh.TetCount(); t += stride, ++n)
    sum += (mesh.rest.row(mesh.tets(t, 0)) - mesh.rest.row(mesh.tets(t, 1))).norm();
  return n > 0 ? sum / n : 0;
}

std::vector<Index> TetsNear(const TetMesh& mesh, const CutBox& region, const SurfaceIndex& index,
                            double slack_mm) {
  std::vector<char> beyond(mesh.VertexCount());  // bits: which of the region's six planes
  for (Index v = 0; v < mesh.VertexCount(); ++v)
    for (int k = 0; k < 3; ++k)
      beyond[v] |= (mesh.rest(v, k) < region.low[k]) << k | (mesh.rest(v, k) > region.high[k])
                                                                << (k + 3);
  std::vector<Index> near;
  for (Index t = 0; t < mesh.TetCount(); ++t) {
    if (beyond[mesh.tets(t, 0)] & beyond[mesh.tets(t, 1)] & beyond[mesh.tets(t, 2)] &
        beyond[mesh.tets(t, 3)])
      continue;
    CutBox tet = BoxOf(mesh.rest, mesh.tets.row(t));
    tet.Grow(slack_mm);
    if (index.MeetsBox(tet.low.transpose(), tet.high.transpose())) near.push_back(t);
  }
  return near;
}

ChosenTets WithRings(const TetMesh& mesh, const std::vector<Index>& core, int rings) {
  ChosenTets chosen;
  chosen.tets = core;
  for (int ring = 0; ring < rings; ++ring) {
    chosen.inner.assign(mesh.VertexCount(), 0);
    for (Index t : chosen.tets)
      for (int k = 0; k < 4; ++k) chosen.inner[mesh.tets(t, k)] = 1;
    chosen.tets.clear();
    for (Index t = 0; t < mesh.TetCount(); ++t)
      if (chosen.inner[mesh.tets(t, 0)] | chosen.inner[mesh.tets(t, 1)] |
          chosen.inner[mesh.tets(t, 2)] | chosen.inner[mesh.tets(t, 3)])
        chosen.tets.push_back(t);
  }
  return chosen;
}

}  // namespace kerf
