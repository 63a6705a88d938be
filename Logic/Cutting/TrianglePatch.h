#pragma once

#include <array>
#include <vector>

#include "Core/SurfaceMesh.h"

namespace kerf {

/// A triangle surface that can be bisected at edges and opened along them.
class TrianglePatch {
 public:
  explicit TrianglePatch(const SurfaceMesh& surface);

  std::vector<Vec3> points;
  std::vector<std::array<int, 3>> triangles;
  std::vector<std::vector<int>> fan;  ///< point → triangles

  std::vector<int> Around(int a, int b) const;
  std::vector<int> Neighbors(int v) const;
  /// Bisects the triangles at a–b; returns the new point.
  int SplitEdge(int a, int b, const Vec3& at);
  /// Triangles around v in groups that hang together across edges v–w for which open(v, w) is
  /// false; the first group keeps v, the others get a copy each. Returns the copies.
  template <class Open>
  std::vector<int> Duplicate(int v, Open open);
  SurfaceMesh Surface() const;
};

template <class Open>
std::vector<int> TrianglePatch::Duplicate(int v, Open open) {
  const std::vector<int> around = fan[v];
  std::vector<int> group(around.size(), -1);
  std::vector<int> copies;
  int groups = 0;
  for (std::size_t start = 0; start < around.size(); ++start) {
    if (group[start] >= 0) continue;
    const int number = groups++;
    std::vector<std::size_t> stack{start};
    group[start] = number;
    while (!stack.empty()) {
      const std::size_t i = stack.back();
      stack.pop_back();
      for (int w : triangles[around[i]]) {
        if (w == v || open(v, w)) continue;
        for (std::size_t j = 0; j < around.size(); ++j) {
          const auto& t = triangles[around[j]];
          if (group[j] < 0 && (t[0] == w || t[1] == w || t[2] == w)) {
            group[j] = number;
            stack.push_back(j);
          }
        }
      }
    }
  }
  for (int number = 1; number < groups; ++number) {
    const int copy = static_cast<int>(points.size());
    points.push_back(points[v]);
    fan.emplace_back();
    copies.push_back(copy);
    for (std::size_t i = 0; i < around.size(); ++i)
      if (group[i] == number) fan[copy].push_back(around[i]);
  }
  for (std::size_t i = 0; i < around.size(); ++i)
    if (group[i] > 0)
      for (int& w : triangles[around[i]])
        if (w == v) w = copies[group[i] - 1];
  fan[v].clear();
  for (std::size_t i = 0; i < around.size(); ++i)
    if (group[i] == 0) fan[v].push_back(around[i]);
  return copies;
}

}  // namespace kerf
