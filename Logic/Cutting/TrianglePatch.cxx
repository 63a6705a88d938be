#include "Cutting/TrianglePatch.h"

#include <algorithm>

namespace kerf {

TrianglePatch::TrianglePatch(const SurfaceMesh& surface) {
  for (Index i = 0; i < surface.points.rows(); ++i)
    points.push_back(surface.points.row(i).transpose());
  fan.resize(points.size());
  for (Index t = 0; t < surface.triangles.rows(); ++t) {
    triangles.push_back(
        {surface.triangles(t, 0), surface.triangles(t, 1), surface.triangles(t, 2)});
    for (int v : triangles.back()) fan[v].push_back(t);
  }
}

std::vector<int> TrianglePatch::Around(int a, int b) const {
  std::vector<int> around;
  for (int t : fan[a])
    for (int w : triangles[t])
      if (w == b) around.push_back(t);
  return around;
}

std::vector<int> TrianglePatch::Neighbors(int v) const {
  std::vector<int> neighbors;
  for (int t : fan[v])
    for (int w : triangles[t])
      if (w != v) neighbors.push_back(w);
  std::sort(neighbors.begin(), neighbors.end());
  neighbors.erase(std::unique(neighbors.begin(), neighbors.end()), neighbors.end());
  return neighbors;
}

int TrianglePatch::SplitEdge(int a, int b, const Vec3& at) {
  const int m = static_cast<int>(points.size());
  points.push_back(at);
  fan.emplace_back();
  for (int old : Around(a, b)) {
    auto half = triangles[old];
    for (int& v : half)
      if (v == a) v = m;
    for (int& v : triangles[old])
      if (v == b) v = m;
    const int fresh = static_cast<int>(triangles.size());
    triangles.push_back(half);
    fan[b].erase(std::find(fan[b].begin(), fan[b].end(), old));
    for (int v : half)
      if (v != m) fan[v].push_back(fresh);
    fan[m].push_back(old);
    fan[m].push_back(fresh);
  }
  return m;
}

SurfaceMesh TrianglePatch::Surface() const {
  SurfaceMesh surface;
  surface.points.resize(points.size(), 3);
  for (std::size_t i = 0; i < points.size(); ++i) surface.points.row(i) = points[i].transpose();
  surface.triangles.resize(triangles.size(), 3);
  for (std::size_t t = 0; t < triangles.size(); ++t)
    surface.triangles.row(t) << triangles[t][0], triangles[t][1], triangles[t][2];
  return surface;
}

}  // namespace kerf
