#include "Core/SurfaceMesh.h"

#include <algorithm>
#include <numeric>
#include <utility>
#include <vector>

#include "Core/Errors.h"

namespace kerf {
namespace {

using Edge = std::pair<Index, Index>;

/// All directed edges (sorted ends, +1/−1 direction, triangle), sorted.
struct DirectedEdge {
  Edge ends;
  int direction;
  Index triangle;
  bool operator<(const DirectedEdge& o) const {
    return std::tie(ends, direction, triangle) < std::tie(o.ends, o.direction, o.triangle);
  }
};

std::vector<DirectedEdge> SortedEdges(const Triangles& triangles) {
  std::vector<DirectedEdge> edges;
  edges.reserve(3 * triangles.rows());
  for (Index t = 0; t < triangles.rows(); ++t)
    for (int k = 0; k < 3; ++k) {
      const Index a = triangles(t, k), b = triangles(t, (k + 1) % 3);
      edges.push_back({{std::min(a, b), std::max(a, b)}, a < b ? 1 : -1, t});
    }
  std::sort(edges.begin(), edges.end());
  return edges;
}

}  // namespace

void SurfaceMesh::Validate(const std::string& file) const {
  for (Index i = 0; i < points.rows(); ++i)
    if (!points.row(i).allFinite())
      throw InputError(file, "point " + std::to_string(i), "coordinate is not a finite number");
  for (Index t = 0; t < triangles.rows(); ++t)
    for (int k = 0; k < 3; ++k)
      if (triangles(t, k) < 0 || triangles(t, k) >= points.rows())
        throw InputError(file, "triangle " + std::to_string(t),
                         "refers to point " + std::to_string(triangles(t, k)) + " of " +
                             std::to_string(points.rows()));
}

double SurfaceMesh::SignedVolume() const {
  if (points.rows() == 0) return 0.0;
  const Vec3 c = points.colwise().mean().transpose();
  double volume = 0.0;
  for (Index t = 0; t < triangles.rows(); ++t) {
    const Vec3 a = points.row(triangles(t, 0)).transpose() - c;
    const Vec3 b = points.row(triangles(t, 1)).transpose() - c;
    const Vec3 d = points.row(triangles(t, 2)).transpose() - c;
    volume += a.dot(b.cross(d));
  }
  return volume / 6.0;
}

double SurfaceMesh::Area() const {
  double area = 0.0;
  for (Index t = 0; t < triangles.rows(); ++t) {
    const Vec3 a = points.row(triangles(t, 0)).transpose();
    const Vec3 b = points.row(triangles(t, 1)).transpose();
    const Vec3 c = points.row(triangles(t, 2)).transpose();
    area += 0.5 * (b - a).cross(c - a).norm();
  }
  return area;
}

bool SurfaceMesh::IsClosedManifold() const {
  const auto edges = SortedEdges(triangles);
  if (edges.empty()) return false;
  for (std::size_t i = 0; i < edges.size(); i += 2) {
    if (i + 1 >= edges.size() || edges[i].ends != edges[i + 1].ends) return false;
    if (edges[i].direction == edges[i + 1].direction) return false;
    if (i + 2 < edges.size() && edges[i + 2].ends == edges[i].ends) return false;
  }
  return true;
}

int SurfaceMesh::Components(std::vector<Index>* component_of_triangle) const {
  std::vector<Index> parent(triangles.rows());
  std::iota(parent.begin(), parent.end(), 0);
  auto find = [&](Index i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  const auto edges = SortedEdges(triangles);
  for (std::size_t i = 1; i < edges.size(); ++i)
    if (edges[i].ends == edges[i - 1].ends) {
      const Index a = find(edges[i].triangle), b = find(edges[i - 1].triangle);
      parent[std::max(a, b)] = std::min(a, b);
    }
  std::vector<Index> number(triangles.rows(), -1);
  int count = 0;
  if (component_of_triangle) component_of_triangle->resize(triangles.rows());
  for (Index t = 0; t < triangles.rows(); ++t) {
    const Index root = find(t);
    if (number[root] < 0) number[root] = count++;
    if (component_of_triangle) (*component_of_triangle)[t] = number[root];
  }
  return count;
}

}  // namespace kerf
