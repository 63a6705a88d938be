#include "Cutting/CutRegion.h"

#include <algorithm>
#include <cstring>
#include <numeric>

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
  std::vector<Index> root(surface.points.rows());
  std::iota(root.begin(), root.end(), 0);
  auto find = [&](Index v) {
    while (root[v] != v) v = root[v] = root[root[v]];
    return v;
  };
  auto join = [&](Index a, Index b) {
    a = find(a);
    b = find(b);
    root[std::max(a, b)] = std::min(a, b);
  };
  for (Index t = 0; t < surface.triangles.rows(); ++t)
    for (int k = 1; k < 3; ++k) join(surface.triangles(t, 0), surface.triangles(t, k));
  const auto one_sheet = [&] {
    for (Index t = 1; t < surface.triangles.rows(); ++t)
      if (find(surface.triangles(t, 0)) != find(surface.triangles(0, 0))) return false;
    return true;
  };
  if (!one_sheet()) {
    std::vector<Index> by_place(root.size());
    std::iota(by_place.begin(), by_place.end(), 0);
    auto less = [&](Index a, Index b) {
      for (int k = 0; k < 3; ++k)
        if (surface.points(a, k) != surface.points(b, k))
          return surface.points(a, k) < surface.points(b, k);
      return false;
    };
    std::sort(by_place.begin(), by_place.end(), less);
    for (std::size_t i = 1; i < by_place.size(); ++i)
      if (!less(by_place[i - 1], by_place[i])) join(by_place[i - 1], by_place[i]);
  }
  std::vector<int> number(root.size(), -1), sheet(surface.triangles.rows());
  int sheets = 0;
  for (Index t = 0; t < surface.triangles.rows(); ++t) {
    int& n = number[find(surface.triangles(t, 0))];
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
