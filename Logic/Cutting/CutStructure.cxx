#include "Cutting/CutStructure.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "Cutting/SurfaceIndex.h"
#include "Cutting/TrianglePatch.h"

namespace kerf {
namespace {

constexpr double kOnS_mm = 1e-7;
constexpr double kOnShare = 1e-4;  // of an edge: a crossing this near to an end counts as the end
constexpr double kReach = 0.5;  // S separates a structure this near to opened faces, of their size

/// What the change opened, as a surface, and which tetrahedra lie on its two sides.
class OpenedSurface {
 public:
  OpenedSurface(const TopologyChange& change)
      : change_(change), faces_(Faces(change)), index_(faces_) {
    for (Index f = 0; f < faces_.triangles.rows(); ++f)
      for (int k = 0; k < 3; ++k)
        reach_mm_ = std::max(reach_mm_, kReach * (Corner(f, k) - Corner(f, (k + 1) % 3)).norm());
    FindTetsAtCorners();
  }

  /// Is the organ open beside p? Beyond its outer boundary yes, beyond the crack front no.
  bool Reaches(const Vec3& p) const {
    const SurfaceNear near = index_.Closest(p, reach_mm_);
    if (near.triangle < 0) return false;
    if (near.distance_mm < 0.1 * reach_mm_ || !near.on_border) return true;
    const OpenedFace& face = change_.opened[near.triangle];
    for (int k = 0; k < 3; ++k) {
      const Vec3 x = Corner(near.triangle, k), u = Corner(near.triangle, (k + 1) % 3) - x,
                 v = Corner(near.triangle, (k + 2) % 3) - x;
      const double share =
          1 - (near.point - x).dot(u.cross(v).cross(v - u)) / u.dot(u.cross(v).cross(v - u));
      if (share > 1e-6 && face.a[k] != face.b[k]) return true;
    }
    return false;
  }
  bool MeetsBox(const Vec3& low, const Vec3& high) const {
    const Vec3 margin = Vec3::Constant(2 * reach_mm_);
    return index_.MeetsBox(low - margin, high + margin);
  }
  double Reach_mm() const { return reach_mm_; }

  /// Binds p to the tetrahedron that holds it best on the side of the opened faces that `direction`
  /// points to.
  void Bind(const Vec3& p, const Vec3& direction, Index* tet, Vec4* weights) const {
    const SurfaceNear near = index_.Closest(p, 1e300);
    const OpenedFace& face = change_.opened[near.triangle];
    const bool side_a = direction.dot(Middle(face.tet_a) - Middle(face.tet_b)) >= 0;
    const std::array<Index, 3>& corners = side_a ? face.a : face.b;
    *tet = side_a ? face.tet_a : face.tet_b;
    *weights = WeightsIn(*tet, p);
    if (weights->minCoeff() >= -1e-9) return;
    for (Index corner : corners)
      for (auto at = FirstAt(corner); at != tets_at_.end() && at->first == corner; ++at) {
        const Index t = at->second;
        if (direction.dot(Middle(t) - near.point) <= 0) continue;
        const Vec4 w = WeightsIn(t, p);
        if (w.minCoeff() <= weights->minCoeff()) continue;
        *tet = t;
        *weights = w;
      }
  }
  /// Side of the nearest opened face that p lies on, as `direction` sees it: > 0 along it.
  double SideOf(const Vec3& p, const Vec3& direction) const {
    const SurfaceNear near = index_.Closest(p, 1e300);
    const double along = (p - near.point).dot(near.normal);
    return near.normal.dot(direction) >= 0 ? along : -along;
  }

 private:
  static CutSurface Faces(const TopologyChange& change) {
    CutSurface faces;
    const Index n = static_cast<Index>(change.opened.size());
    faces.points.resize(3 * n, 3);
    faces.triangles.resize(n, 3);
    for (Index f = 0; f < n; ++f)
      for (int k = 0; k < 3; ++k) {
        faces.points.row(3 * f + k) = change.mesh.rest.row(change.opened[f].a[k]);
        faces.triangles(f, k) = 3 * f + k;
      }
    return faces;
  }
  /// Of the tetrahedra that are new or behind opened faces, those at the faces' corners.
  void FindTetsAtCorners() {
    std::vector<Index> corners, tets = change_.new_tets;
    for (const OpenedFace& face : change_.opened) {
      corners.insert(corners.end(), face.a.begin(), face.a.end());
      corners.insert(corners.end(), face.b.begin(), face.b.end());
      tets.insert(tets.end(), {face.tet_a, face.tet_b});
    }
    std::sort(corners.begin(), corners.end());
    for (Index t : tets)
      for (int k = 0; k < 4; ++k) {
        const Index v = change_.mesh.tets(t, k);
        if (std::binary_search(corners.begin(), corners.end(), v)) tets_at_.push_back({v, t});
      }
    std::sort(tets_at_.begin(), tets_at_.end());
    tets_at_.erase(std::unique(tets_at_.begin(), tets_at_.end()), tets_at_.end());
  }
  std::vector<std::pair<Index, Index>>::const_iterator FirstAt(Index corner) const {
    return std::lower_bound(tets_at_.begin(), tets_at_.end(), std::pair<Index, Index>{corner, -1});
  }
  Vec3 Corner(Index f, int k) const { return faces_.points.row(3 * f + k).transpose(); }
  Vec4 WeightsIn(Index t, const Vec3& p) const {
    const auto c = change_.mesh.tets.row(t);
    const Points& x = change_.mesh.rest;
    return BarycentricWeights(p, x.row(c[0]).transpose(), x.row(c[1]).transpose(),
                              x.row(c[2]).transpose(), x.row(c[3]).transpose());
  }
  Vec3 Middle(Index t) const {
    Vec3 p = Vec3::Zero();
    for (int k = 0; k < 4; ++k) p += change_.mesh.rest.row(change_.mesh.tets(t, k)).transpose() / 4;
    return p;
  }

  const TopologyChange& change_;
  CutSurface faces_;
  SurfaceIndex index_;
  std::vector<std::pair<Index, Index>> tets_at_;  ///< corner, tetrahedron; ascending
  double reach_mm_ = 0;
};

struct NearTriangles {
  std::vector<Index> triangle;  // rows of the structure
  std::vector<Index> point;     // rows, ascending
  SurfaceMesh surface;          // in numbers of its own
};

NearTriangles TrianglesNear(const SurfaceMesh& rest, const OpenedSurface& opened) {
  NearTriangles near;
  std::vector<Index> number(rest.points.rows(), -1);
  for (Index t = 0; t < rest.triangles.rows(); ++t) {
    const Vec3 a = rest.points.row(rest.triangles(t, 0)).transpose();
    const Vec3 b = rest.points.row(rest.triangles(t, 1)).transpose();
    const Vec3 c = rest.points.row(rest.triangles(t, 2)).transpose();
    if (!opened.MeetsBox(a.cwiseMin(b).cwiseMin(c), a.cwiseMax(b).cwiseMax(c))) continue;
    near.triangle.push_back(t);
    for (int k = 0; k < 3; ++k) number[rest.triangles(t, k)] = 0;
  }
  for (Index i = 0; i < rest.points.rows(); ++i)
    if (number[i] == 0) {
      number[i] = static_cast<Index>(near.point.size());
      near.point.push_back(i);
    }
  near.surface.points.resize(near.point.size(), 3);
  for (std::size_t i = 0; i < near.point.size(); ++i)
    near.surface.points.row(i) = rest.points.row(near.point[i]);
  near.surface.triangles.resize(near.triangle.size(), 3);
  for (std::size_t i = 0; i < near.triangle.size(); ++i)
    for (int k = 0; k < 3; ++k)
      near.surface.triangles(i, k) = number[rest.triangles(near.triangle[i], k)];
  return near;
}

class StructureCutter {
 public:
  StructureCutter(const SurfaceMesh& near, const SurfaceIndex& s, const OpenedSurface& opened)
      : patch(near), s_(s), opened_(opened), on_(patch.points.size(), 0) {
    for (std::size_t v = 0; v < patch.points.size(); ++v)
      on_[v] = s_.Closest(patch.points[v], kOnS_mm).triangle >= 0;
  }

  /// Does S cross this triangle where the organ was opened?
  bool Crossed(int t) const {
    std::vector<double> hits;
    for (int k = 0; k < 3; ++k) {
      const Vec3 &a = patch.points[patch.triangles[t][k]],
                 &b = patch.points[patch.triangles[t][(k + 1) % 3]];
      s_.Crossings(a, b, &hits);
      for (double h : hits)
        if (opened_.Reaches(a + h * (b - a))) return true;
    }
    return false;
  }

  void Split() {
    std::vector<std::array<int, 2>> jobs;
    for (const auto& t : patch.triangles)
      for (int k = 0; k < 3; ++k)
        jobs.push_back({std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3])});
    std::sort(jobs.begin(), jobs.end());
    jobs.erase(std::unique(jobs.begin(), jobs.end()), jobs.end());
    const std::size_t limit = 8 * patch.points.size() + 64;
    for (std::size_t i = 0; i < jobs.size() && patch.points.size() < limit; ++i) {
      const auto [a, b] = jobs[i];
      if (patch.Around(a, b).empty()) continue;
      const double t = Crossing(a, b);
      if (t < 0) continue;
      const int m = patch.SplitEdge(a, b, (1 - t) * patch.points[a] + t * patch.points[b]);
      on_.push_back(1);
      for (int w : patch.Neighbors(m)) jobs.push_back({w, m});
    }
  }

  /// Opens the patch along edges on S. `direction_of`: for every point on S, the side that it now
  /// belongs to.
  void Open() {
    std::set<std::array<int, 2>> open;  // looked up; its order is that of the numbers
    std::vector<int> ends;
    for (const auto& t : patch.triangles)
      for (int k = 0; k < 3; ++k) {
        const int a = t[k], b = t[(k + 1) % 3];
        if (a < b && on_[a] && on_[b] && Separates(a, b)) {
          open.insert({a, b});
          ends.push_back(a);
          ends.push_back(b);
        }
      }
    std::sort(ends.begin(), ends.end());
    ends.erase(std::unique(ends.begin(), ends.end()), ends.end());
    origin.resize(patch.points.size());
    for (std::size_t v = 0; v < origin.size(); ++v) origin[v] = static_cast<int>(v);
    auto is_open = [&](int v, int w) {
      const int a = origin[v], b = origin[w];
      return open.count({std::min(a, b), std::max(a, b)}) > 0;
    };
    for (int v : ends)
      for (std::size_t copies = patch.Duplicate(v, is_open).size(); copies > 0; --copies) {
        origin.push_back(v);
        on_.push_back(1);
      }
  }

  bool On(int v) const { return on_[v]; }
  /// Normal of S near v, towards the side where the triangles of v lie.
  Vec3 SideDirection(int v) const {
    const SurfaceNear near = s_.Closest(patch.points[v], 1e300);
    double side = 0;
    for (int w : patch.Neighbors(v))
      if (!on_[w]) side += (patch.points[w] - near.point).dot(near.normal);
    return side >= 0 ? near.normal : Vec3(-near.normal);
  }

  TrianglePatch patch;
  std::vector<int> origin;  ///< point → point before opening

 private:
  double Crossing(int a, int b) {
    if (on_[a] && on_[b]) return -1;
    std::vector<double> hits;
    s_.Crossings(patch.points[a], patch.points[b], &hits);
    for (double t : hits) {
      const double share = kOnShare;
      if (!opened_.Reaches(patch.points[a] + t * (patch.points[b] - patch.points[a]))) continue;
      if (t < share || t > 1 - share) {
        on_[t < share ? a : b] = 1;
        continue;
      }
      if (on_[a] && t < 0.05) continue;  // leaves S only there
      if (on_[b] && t > 0.95) continue;
      return t;
    }
    return -1;
  }

  bool Separates(int a, int b) const {
    const Vec3 middle = 0.5 * (patch.points[a] + patch.points[b]);
    const double length = (patch.points[a] - patch.points[b]).norm();
    const SurfaceNear near = s_.Closest(middle, 0.35 * length + kOnS_mm);
    if (near.triangle < 0 || !opened_.Reaches(middle)) return false;
    double low = 0, high = 0;
    for (int t : patch.Around(a, b))
      for (int w : patch.triangles[t])
        if (w != a && w != b) {
          const double side = (patch.points[w] - near.point).dot(near.normal);
          low = std::min(low, side);
          high = std::max(high, side);
        }
    return low < 0 && high > 0;
  }

  const SurfaceIndex& s_;
  const OpenedSurface& opened_;
  std::vector<char> on_;
};

}  // namespace

Structure CutStructureSurface(const Structure& structure, const CutSurface& surface,
                              const TopologyChange& change, const TetMesh& old_mesh,
                              StructureCutMode mode) {
  Structure out = structure;
  if (!change.changed) return out;
  out.embedding = change.MapEmbedding(structure.embedding, old_mesh);
  const SurfaceIndex s(surface);
  if (change.opened.empty() || s.Empty()) return out;
  const OpenedSurface opened(change);
  const NearTriangles near = TrianglesNear(structure.rest, opened);
  if (near.triangle.empty()) return out;
  StructureCutter cutter(near.surface, s, opened);

  // A point between S and the faces that stand for it hangs on the side that S puts it on.
  auto bind_by_side = [&](const Vec3& p, Index row) {
    const SurfaceNear at = s.Closest(p, opened.Reach_mm());
    if (at.triangle < 0 || !opened.Reaches(p)) return;
    const Vec3 direction = (p - at.point).dot(at.normal) >= 0 ? at.normal : Vec3(-at.normal);
    if (opened.SideOf(p, direction) >= 0) return;
    Vec4 weights;
    opened.Bind(p, direction, &out.embedding.tet[row], &weights);
    out.embedding.weights.row(row) = weights.transpose();
  };
  const Index old_triangles = static_cast<Index>(structure.rest.triangles.rows());
  if (mode == StructureCutMode::DeleteTriangles) {
    std::vector<char> gone(old_triangles, 0);
    for (std::size_t t = 0; t < near.triangle.size(); ++t)
      gone[near.triangle[t]] = cutter.Crossed(static_cast<int>(t));
    Index kept = 0;
    for (Index t = 0; t < old_triangles; ++t)
      if (!gone[t]) out.rest.triangles.row(kept++) = structure.rest.triangles.row(t);
    out.rest.triangles.conservativeResize(kept, 3);
    for (std::size_t v = 0; v < near.point.size(); ++v)
      bind_by_side(cutter.patch.points[v], near.point[v]);
    return out;
  }

  cutter.Split();
  cutter.Open();
  const TrianglePatch& patch = cutter.patch;
  std::vector<Index> row(patch.points.size());
  Index points = static_cast<Index>(structure.rest.points.rows());
  for (std::size_t v = 0; v < row.size(); ++v)
    row[v] = v < near.point.size() ? near.point[v] : points++;
  out.rest.points.conservativeResize(points, 3);
  out.embedding.tet.resize(points);
  out.embedding.weights.conservativeResize(points, 4);
  for (std::size_t v = 0; v < row.size(); ++v) {
    const bool fresh = v >= near.point.size();
    const Vec3& p = patch.points[v];
    if (fresh) out.rest.points.row(row[v]) = p.transpose();
    if (patch.fan[v].empty()) continue;
    if (!cutter.On(static_cast<int>(v))) {
      bind_by_side(p, row[v]);
      continue;
    }
    if (!fresh && !opened.Reaches(p)) continue;
    const Vec3 direction = cutter.SideDirection(static_cast<int>(v));
    Vec4 weights;
    opened.Bind(p, direction, &out.embedding.tet[row[v]], &weights);
    out.embedding.weights.row(row[v]) = weights.transpose();
  }
  const Index fresh = static_cast<Index>(patch.triangles.size() - near.triangle.size());
  out.rest.triangles.conservativeResize(old_triangles + fresh, 3);
  for (std::size_t t = 0; t < patch.triangles.size(); ++t) {
    const Index at = t < near.triangle.size()
                         ? near.triangle[t]
                         : old_triangles + static_cast<Index>(t - near.triangle.size());
    for (int k = 0; k < 3; ++k) out.rest.triangles(at, k) = row[patch.triangles[t][k]];
  }
  return out;
}

std::vector<double> PieceVolumes_mm3(const SurfaceMesh& surface) {
  std::vector<Index> component;
  std::vector<double> volumes(surface.Components(&component), 0.0);
  auto point = [&](Index v) -> Vec3 { return surface.points.row(v).transpose(); };
  std::vector<std::array<Index, 2>> edges;  // directed
  for (Index t = 0; t < surface.triangles.rows(); ++t) {
    const auto v = surface.triangles.row(t);
    volumes[component[t]] += point(v[0]).dot(point(v[1]).cross(point(v[2]))) / 6;
    for (int k = 0; k < 3; ++k) edges.push_back({v[k], v[(k + 1) % 3]});
  }
  std::sort(edges.begin(), edges.end());
  // Rim edges have no partner; each component's rim is closed by triangles to the rim's middle.
  std::vector<Vec3> middle(volumes.size(), Vec3::Zero());
  std::vector<int> count(volumes.size(), 0);
  std::vector<std::pair<Index, std::array<Index, 2>>> rim;
  for (Index t = 0; t < surface.triangles.rows(); ++t)
    for (int k = 0; k < 3; ++k) {
      const Index a = surface.triangles(t, k), b = surface.triangles(t, (k + 1) % 3);
      if (std::binary_search(edges.begin(), edges.end(), std::array<Index, 2>{b, a})) continue;
      rim.push_back({component[t], {a, b}});
      middle[component[t]] += point(a);
      ++count[component[t]];
    }
  for (const auto& [c, edge] : rim)
    volumes[c] += (middle[c] / count[c]).dot(point(edge[1]).cross(point(edge[0]))) / 6;
  return volumes;
}

}  // namespace kerf
