#include "Core/TetMesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <utility>

#include "Core/Errors.h"

namespace kerf {
namespace {

/// Outward faces of a positive tetrahedron: face k is opposite to vertex k.
constexpr int kFaces[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};

/// A face of a tetrahedron. 32 bits each: most of the time that ordering takes is memory.
struct FaceKey {
  std::uint32_t smallest, middle, largest;  ///< its vertices, less the mesh's first
  std::uint32_t corner;                     ///< 4 tet + face
  Index Tet() const { return corner / 4; }
  std::uint64_t Others() const { return std::uint64_t{middle} << 32 | largest; }
  bool SameFace(const FaceKey& o) const { return smallest == o.smallest && Others() == o.Others(); }
};

/// Faces by their smallest vertex: those of one lie between two entries of `end`.
struct GroupedFaces {
  std::vector<FaceKey> faces;
  std::vector<std::size_t> end;  ///< of each group
};

/// Vertices are counted first, so that faces find their group without being sorted: a cut asks for
/// this in every frame in which it grows.
GroupedFaces GroupFaces(const Tets& tets) {
  GroupedFaces out;
  if (tets.rows() == 0) return out;
  if (tets.rows() >= Index{1} << 30) throw UsageError("a mesh of more than 2^30 tetrahedra");
  const Index first = tets.minCoeff();
  out.end.assign(static_cast<std::size_t>(tets.maxCoeff() - first) + 2, 0);
  const auto for_faces = [&](auto&& use) {
    for (Index t = 0; t < tets.rows(); ++t)
      for (int f = 0; f < 4; ++f) {
        auto a = static_cast<std::uint32_t>(tets(t, kFaces[f][0]) - first);
        auto b = static_cast<std::uint32_t>(tets(t, kFaces[f][1]) - first);
        auto c = static_cast<std::uint32_t>(tets(t, kFaces[f][2]) - first);
        if (a > b) std::swap(a, b);
        if (b > c) std::swap(b, c);
        if (a > b) std::swap(a, b);
        use(FaceKey{a, b, c, static_cast<std::uint32_t>(4 * t + f)});
      }
  };
  for_faces([&](const FaceKey& key) { ++out.end[key.smallest + 1]; });
  std::partial_sum(out.end.begin(), out.end.end(), out.end.begin());
  out.faces.resize(static_cast<std::size_t>(4 * tets.rows()));
  // Each start moves on to where its group ends.
  for_faces([&](const FaceKey& key) { out.faces[out.end[key.smallest]++] = key; });
  return out;
}

/// Faces of all tetrahedra in order, by vertices, then by corner.
std::vector<FaceKey> SortedFaces(const Tets& tets) {
  GroupedFaces grouped = GroupFaces(tets);
  std::size_t begin = 0;
  for (const std::size_t end : grouped.end) {
    std::sort(grouped.faces.begin() + begin, grouped.faces.begin() + end,
              [](const FaceKey& l, const FaceKey& r) {
                return l.Others() != r.Others() ? l.Others() < r.Others() : l.corner < r.corner;
              });
    begin = end;
  }
  return std::move(grouped.faces);
}

/// Corners of the faces that only one tetrahedron has, in rising order.
std::vector<std::uint32_t> SingleFaces(const Tets& tets) {
  constexpr std::size_t kFew = 64;  // compared each with each; more are sorted
  GroupedFaces grouped = GroupFaces(tets);
  std::vector<std::uint32_t> single;
  std::vector<std::uint64_t> others;
  std::size_t begin = 0;
  for (const std::size_t end : grouped.end) {
    FaceKey* const face = grouped.faces.data() + begin;
    const std::size_t n = end - begin;
    begin = end;
    if (n > kFew) {
      std::sort(face, face + n,
                [](const FaceKey& l, const FaceKey& r) { return l.Others() < r.Others(); });
      for (std::size_t i = 0; i < n; ++i)
        if ((i == 0 || !face[i].SameFace(face[i - 1])) &&
            (i + 1 == n || !face[i].SameFace(face[i + 1])))
          single.push_back(face[i].corner);
      continue;
    }
    others.resize(n);
    for (std::size_t i = 0; i < n; ++i) others[i] = face[i].Others();
    for (std::size_t i = 0; i < n; ++i) {
      int same = 0;
      for (std::size_t j = 0; j < n; ++j) same += others[j] == others[i];
      if (same == 1) single.push_back(face[i].corner);
    }
  }
  std::sort(single.begin(), single.end());
  return single;
}

/// Around each boundary vertex the triangles must form one fan.
bool VertexManifold(const Triangles& triangles, Index vertex_count) {
  std::vector<std::vector<std::pair<Index, Index>>> fans(vertex_count);
  for (Index t = 0; t < triangles.rows(); ++t)
    for (int k = 0; k < 3; ++k)
      fans[triangles(t, k)].push_back({triangles(t, (k + 1) % 3), triangles(t, (k + 2) % 3)});
  for (auto& fan : fans) {
    if (fan.empty()) continue;
    std::map<Index, Index> next;
    for (auto& e : fan)
      if (!next.insert(e).second) return false;
    const Index start = fan.front().first;
    Index at = start;
    std::size_t steps = 0;
    do {
      const auto it = next.find(at);
      if (it == next.end()) return false;
      at = it->second;
      ++steps;
    } while (at != start && steps <= fan.size());
    if (steps != fan.size()) return false;
  }
  return true;
}

}  // namespace

double TetVolume(const Points& positions, const Tets& tets, Index t) {
  const Vec3 a = positions.row(tets(t, 0)).transpose();
  const Vec3 b = positions.row(tets(t, 1)).transpose() - a;
  const Vec3 c = positions.row(tets(t, 2)).transpose() - a;
  const Vec3 d = positions.row(tets(t, 3)).transpose() - a;
  return b.dot(c.cross(d)) / 6.0;
}

double SmallestDihedral_deg(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const std::array<Vec3, 4> x{a, b, c, d};
  std::array<Vec3, 4> normal;
  for (int f = 0; f < 4; ++f)
    normal[f] = (x[kFaces[f][1]] - x[kFaces[f][0]]).cross(x[kFaces[f][2]] - x[kFaces[f][0]]);
  double smallest = 180.0;
  for (int i = 0; i < 4; ++i)
    for (int j = i + 1; j < 4; ++j) {
      const double length = normal[i].norm() * normal[j].norm();
      if (length <= 0.0) return 0.0;
      const double cosine = std::clamp(-normal[i].dot(normal[j]) / length, -1.0, 1.0);
      smallest = std::min(smallest, std::acos(cosine) * 180.0 / M_PI);
    }
  const double volume = (b - a).dot((c - a).cross(d - a));
  return volume < 0.0 ? -smallest : smallest;
}

void TetMesh::Validate(const std::string& file) const {
  if (region.size() != static_cast<std::size_t>(tets.rows()))
    throw InputError(file, "region",
                     "has " + std::to_string(region.size()) + " values for " +
                         std::to_string(tets.rows()) + " tetrahedra");
  for (Index i = 0; i < rest.rows(); ++i)
    if (!rest.row(i).allFinite())
      throw InputError(file, "vertex " + std::to_string(i), "coordinate is not a finite number");
  for (Index t = 0; t < tets.rows(); ++t) {
    for (int k = 0; k < 4; ++k)
      if (tets(t, k) < 0 || tets(t, k) >= rest.rows())
        throw InputError(file, "tetrahedron " + std::to_string(t),
                         "refers to vertex " + std::to_string(tets(t, k)) + " of " +
                             std::to_string(rest.rows()));
    if (!(TetVolume(rest, tets, t) > 0.0))
      throw InputError(file, "tetrahedron " + std::to_string(t), "is inverted or flat");
  }
}

Triangles BoundaryFaces(const Tets& tets, std::vector<Index>* tet_of_face) {
  const std::vector<std::uint32_t> boundary = SingleFaces(tets);
  Triangles out(static_cast<Index>(boundary.size()), 3);
  if (tet_of_face) tet_of_face->resize(boundary.size());
  for (std::size_t i = 0; i < boundary.size(); ++i) {
    const Index t = boundary[i] / 4, f = boundary[i] % 4;
    for (int k = 0; k < 3; ++k) out(i, k) = tets(t, kFaces[f][k]);
    if (tet_of_face) (*tet_of_face)[i] = t;
  }
  return out;
}

SurfaceMesh BoundarySurface(const TetMesh& mesh, const Points& positions,
                            std::vector<Index>* vertex_of_point) {
  SurfaceMesh surface;
  surface.triangles = BoundaryFaces(mesh.tets);
  std::vector<Index> point_of(mesh.VertexCount(), -1), vertices;
  for (Index t = 0; t < surface.triangles.rows(); ++t)
    for (int k = 0; k < 3; ++k) point_of[surface.triangles(t, k)] = 0;
  for (Index v = 0; v < mesh.VertexCount(); ++v)
    if (point_of[v] == 0) {
      point_of[v] = static_cast<Index>(vertices.size());
      vertices.push_back(v);
    }
  surface.points.resize(vertices.size(), 3);
  for (std::size_t i = 0; i < vertices.size(); ++i)
    surface.points.row(i) = positions.row(vertices[i]);
  for (Index t = 0; t < surface.triangles.rows(); ++t)
    for (int k = 0; k < 3; ++k) surface.triangles(t, k) = point_of[surface.triangles(t, k)];
  if (vertex_of_point) *vertex_of_point = std::move(vertices);
  return surface;
}

int TetComponents(const Tets& tets, std::vector<Index>* component_of_tet) {
  std::vector<Index> parent(tets.rows());
  std::iota(parent.begin(), parent.end(), 0);
  auto find = [&](Index i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  const auto faces = SortedFaces(tets);
  for (std::size_t i = 1; i < faces.size(); ++i)
    if (faces[i].SameFace(faces[i - 1])) {
      const Index a = find(faces[i].Tet()), b = find(faces[i - 1].Tet());
      parent[std::max(a, b)] = std::min(a, b);
    }
  std::vector<Index> number(tets.rows(), -1);
  component_of_tet->resize(tets.rows());
  int count = 0;
  for (Index t = 0; t < tets.rows(); ++t) {
    const Index root = find(t);
    if (number[root] < 0) number[root] = count++;
    (*component_of_tet)[t] = number[root];
  }
  return count;
}

MeshQuality MeasureQuality(const TetMesh& mesh, const Points& positions) {
  MeshQuality quality;
  quality.vertices = mesh.VertexCount();
  quality.tets = mesh.TetCount();
  std::vector<Index> component;
  quality.components = TetComponents(mesh.tets, &component);
  quality.smallest_dihedral_deg = 180.0;
  quality.smallest_tet_volume_mm3 = std::numeric_limits<double>::infinity();
  std::vector<char> used(mesh.VertexCount(), 0);
  for (Index t = 0; t < mesh.TetCount(); ++t) {
    const double volume = TetVolume(positions, mesh.tets, t);
    quality.volume_mm3 += volume;
    quality.smallest_tet_volume_mm3 = std::min(quality.smallest_tet_volume_mm3, volume);
    if (!(volume > 0.0)) ++quality.inverted;
    std::array<Vec3, 4> x;
    for (int k = 0; k < 4; ++k) {
      used[mesh.tets(t, k)] = 1;
      x[k] = positions.row(mesh.tets(t, k)).transpose();
    }
    quality.smallest_dihedral_deg =
        std::min(quality.smallest_dihedral_deg, SmallestDihedral_deg(x[0], x[1], x[2], x[3]));
  }
  quality.orphans = static_cast<Index>(std::count(used.begin(), used.end(), 0));
  SurfaceMesh boundary;
  boundary.points = positions;
  boundary.triangles = BoundaryFaces(mesh.tets);
  quality.manifold_boundary =
      boundary.IsClosedManifold() && VertexManifold(boundary.triangles, mesh.VertexCount());
  return quality;
}

}  // namespace kerf
