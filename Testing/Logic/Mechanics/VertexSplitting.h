#pragma once

#include <algorithm>
#include <random>
#include <utility>
#include <vector>

#include "Core/TopologyChange.h"

namespace kerf::testing {

/// Splits a vertex: the tetrahedra around it whose centroid lies above a plane through it get a
/// copy of it. The changed tetrahedra count as kept (the material is the same) or as new ones, as a
/// cutter may choose.
inline TopologyChange SplitVertex(const TetMesh& mesh, Index vertex, const Vec3& normal,
                                  bool keep) {
  TopologyChange change;
  change.mesh = mesh;
  const Index n = mesh.VertexCount();
  change.vertex_parents.resize(n);
  change.vertex_weights = Weights4::Zero(n, 4);
  for (Index v = 0; v < n; ++v) change.vertex_parents[v] = {v, v, v, v};
  change.vertex_weights.col(0).setOnes();
  for (Index t = 0; t < mesh.TetCount(); ++t) {
    change.parent_tet.push_back(t);
    change.kept_tet.push_back(t);
  }
  std::vector<std::pair<Index, int>> above;
  int below = 0;
  for (Index t = 0; t < mesh.TetCount(); ++t)
    for (int a = 0; a < 4; ++a) {
      if (mesh.tets(t, a) != vertex) continue;
      Vec3 centroid = Vec3::Zero();
      for (int b = 0; b < 4; ++b) centroid += 0.25 * mesh.rest.row(mesh.tets(t, b)).transpose();
      if (normal.dot(centroid - mesh.rest.row(vertex).transpose()) > 0.0)
        above.emplace_back(t, a);
      else
        ++below;
    }
  if (above.empty() || below == 0) return change;
  change.changed = true;
  change.mesh.rest.conservativeResize(n + 1, 3);
  change.mesh.rest.row(n) = mesh.rest.row(vertex);
  change.vertex_parents.push_back({vertex, vertex, vertex, vertex});
  change.vertex_weights.conservativeResize(n + 1, 4);
  change.vertex_weights.row(n) << 1, 0, 0, 0;
  for (const auto& [t, a] : above) {
    change.mesh.tets(t, a) = n;
    if (keep) continue;
    change.kept_tet[t] = -1;
    change.new_tets.push_back(t);
  }
  return change;
}

/// Vertices with tetrahedra on both sides of the plane at `x` (by centroid), by rising y.
inline std::vector<Index> SeamAt(const TetMesh& mesh, double x) {
  std::vector<char> sides(mesh.VertexCount(), 0);
  for (Index t = 0; t < mesh.TetCount(); ++t) {
    double middle = 0.0;
    for (int a = 0; a < 4; ++a) middle += 0.25 * mesh.rest(mesh.tets(t, a), 0);
    for (int a = 0; a < 4; ++a) sides[mesh.tets(t, a)] |= middle > x ? 2 : 1;
  }
  std::vector<std::pair<double, Index>> seam;
  for (Index v = 0; v < mesh.VertexCount(); ++v)
    if (sides[v] == 3) seam.emplace_back(mesh.rest(v, 1), v);
  std::sort(seam.begin(), seam.end());
  std::vector<Index> vertices;
  for (const auto& [y, v] : seam) vertices.push_back(v);
  return vertices;
}

/// Opens a planar cut x = `at` (rest) through all vertices on it with y > `from`, one after the
/// other is up to the caller: all vertices of `vertices` are split along the plane at once.
inline TopologyChange OpenPlane(const TetMesh& mesh, const std::vector<Index>& vertices,
                                const Vec3& normal, double offset) {
  TopologyChange change;
  change.mesh = mesh;
  change.changed = !vertices.empty();
  const Index n = mesh.VertexCount(), added = static_cast<Index>(vertices.size());
  std::vector<Index> copy(n, -1);
  change.mesh.rest.conservativeResize(n + added, 3);
  change.vertex_weights = Weights4::Zero(n + added, 4);
  change.vertex_weights.col(0).setOnes();
  change.vertex_parents.resize(n + added);
  for (Index v = 0; v < n; ++v) change.vertex_parents[v] = {v, v, v, v};
  for (Index i = 0; i < added; ++i) {
    const Index v = vertices[i];
    copy[v] = n + i;
    change.mesh.rest.row(n + i) = mesh.rest.row(v);
    change.vertex_parents[n + i] = {v, v, v, v};
  }
  for (Index t = 0; t < mesh.TetCount(); ++t) {
    change.parent_tet.push_back(t);
    change.kept_tet.push_back(t);
    Vec3 centroid = Vec3::Zero();
    for (int a = 0; a < 4; ++a) centroid += 0.25 * mesh.rest.row(mesh.tets(t, a)).transpose();
    bool changed = false;
    for (int a = 0; a < 4; ++a) {
      const Index v = mesh.tets(t, a);
      if (copy[v] < 0 || normal.dot(centroid) <= offset) continue;
      change.mesh.tets(t, a) = copy[v];
      changed = true;
    }
    if (!changed) continue;
    change.kept_tet[t] = -1;
    change.new_tets.push_back(t);
  }
  return change;
}

}  // namespace kerf::testing
