#include "Cutting/Separation.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "Cutting/CutRemeshing.h"
#include "Cutting/DisjointSets.h"

namespace kerf {
namespace {

constexpr int kFaces[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};
constexpr double kBeyondBorder = 0.15;  // of the face's longest edge
constexpr double kBesideS = 0.35;
constexpr double kFront = 1.2;     // mean edges: the crack front is this near to the end of S
constexpr double kParallel = 0.3;  // cosine

struct OpenFace {
  std::array<int, 3> v;  // sorted
  std::array<int, 2> tet;
  double area_mm2;
  bool open = true;
};

struct Touch {
  std::array<int, 3> v;
  int tet;
  bool operator<(const Touch& o) const {
    for (int k = 0; k < 3; ++k)
      if (v[k] != o.v[k]) return v[k] < o.v[k];
    return tet < o.tet;
  }
};

/// Which corner of t is none of the face's.
int CornerOpposite(const CutPatch& patch, int t, const std::array<int, 3>& face) {
  for (int k = 0; k < 3; ++k) {
    const int w = patch.tets[t].v[k];
    if (w != face[0] && w != face[1] && w != face[2]) return k;
  }
  return 3;
}

/// The side of S that a tetrahedron lies on: by its corners away from the face, by its middle where
/// they are on S too.
double SideOf(const CutPatch& patch, int t, const std::array<int, 3>& face, const SurfaceNear& near,
              const SurfaceIndex& surface) {
  const int o = patch.tets[t].v[CornerOpposite(patch, t, face)];
  if (!patch.vertices[o].on) return (patch.vertices[o].rest - near.point).dot(near.normal);
  Vec3 middle = Vec3::Zero();
  for (int w : patch.tets[t].v) middle += patch.vertices[w].rest / 4;
  const SurfaceNear at = surface.Closest(middle, 1e300);
  return (middle - at.point).dot(near.normal);
}

std::vector<OpenFace> FacesOnS(const SurfaceIndex& surface, const CutPatch& patch) {
  std::vector<Touch> touches;
  for (std::size_t t = 0; t < patch.tets.size(); ++t)
    for (const auto& f : kFaces) {
      Touch touch{{patch.tets[t].v[f[0]], patch.tets[t].v[f[1]], patch.tets[t].v[f[2]]},
                  static_cast<int>(t)};
      bool take = true;
      for (int w : touch.v) take = take && patch.vertices[w].on && !patch.vertices[w].frozen;
      if (!take) continue;
      std::sort(touch.v.begin(), touch.v.end());
      touches.push_back(touch);
    }
  std::sort(touches.begin(), touches.end());
  std::vector<OpenFace> faces;
  for (std::size_t i = 0; i + 1 < touches.size(); ++i) {
    if (touches[i].v != touches[i + 1].v) continue;
    const auto& v = touches[i].v;
    const Vec3 a = patch.vertices[v[0]].rest, b = patch.vertices[v[1]].rest,
               c = patch.vertices[v[2]].rest;
    const double longest = std::max({(a - b).norm(), (b - c).norm(), (c - a).norm()});
    const Vec3 center = (a + b + c) / 3, normal = (b - a).cross(c - a);
    const SurfaceNear near = surface.Closest(center, longest);
    if (near.triangle < 0) continue;
    if (near.distance_mm > (near.on_border ? kBeyondBorder : kBesideS) * longest) continue;
    if (std::abs(normal.normalized().dot(near.normal)) < kParallel) continue;
    const double side0 = SideOf(patch, touches[i].tet, v, near, surface);
    const double side1 = SideOf(patch, touches[i + 1].tet, v, near, surface);
    if (side0 * side1 >= 0) continue;
    faces.push_back({v, {touches[i].tet, touches[i + 1].tet}, 0.5 * normal.norm()});
  }
  return faces;
}

/// Is the fan of boundary triangles one closed ring?
bool OneRing(const std::vector<CutPatch::FanFace>& fan) {
  if (fan.empty()) return true;
  std::vector<CutPatch::FanFace> next = fan;
  std::sort(next.begin(), next.end());
  for (std::size_t i = 0; i + 1 < next.size(); ++i)
    if (next[i][0] == next[i + 1][0]) return false;
  int at = next[0][0];
  std::size_t steps = 0;
  do {
    const auto it = std::lower_bound(next.begin(), next.end(), CutPatch::FanFace{at, -1});
    if (it == next.end() || (*it)[0] != at) return false;
    at = (*it)[1];
    ++steps;
  } while (at != next[0][0] && steps <= next.size());
  return steps == next.size();
}

class Opening {
 public:
  Opening(const CutPatch& closed, const std::vector<OpenFace>& faces) : patch(closed) {
    origin.resize(patch.vertices.size());
    std::iota(origin.begin(), origin.end(), 0);
    std::vector<std::vector<const OpenFace*>> faces_of(patch.vertices.size());
    for (const OpenFace& face : faces)
      if (face.open)
        for (int v : face.v) faces_of[v].push_back(&face);
    for (std::size_t v = 0; v < faces_of.size(); ++v)
      if (!faces_of[v].empty()) {
        touched.push_back(static_cast<int>(v));
        Duplicate(closed, static_cast<int>(v), faces_of[v]);
      }
  }

  /// The corner of a tetrahedron that stems from v of the closed patch.
  int CornerOf(int t, int v) const {
    for (int w : patch.tets[t].v)
      if (origin[w] == v) return w;
    return -1;
  }

  CutPatch patch;
  std::vector<int> origin;   ///< vertex → vertex of the closed patch
  std::vector<int> touched;  ///< vertices at open faces, and their duplicates
  Index duplicated = 0;

 private:
  void Duplicate(const CutPatch& closed, int v, const std::vector<const OpenFace*>& open) {
    const auto& star = closed.star[v];
    struct Side {
      std::uint64_t edge;
      int slot;
    };
    std::vector<Side> sides;
    sides.reserve(3 * star.size());
    for (std::size_t i = 0; i < star.size(); ++i)
      for (const auto& f : kFaces)
        for (int k = 0; k < 3; ++k)
          if (closed.tets[star[i]].v[f[k]] == v) {
            const int a = closed.tets[star[i]].v[f[(k + 1) % 3]],
                      b = closed.tets[star[i]].v[f[(k + 2) % 3]];
            sides.push_back({EdgeKey(a, b), static_cast<int>(i)});
          }
    std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
      return a.edge != b.edge ? a.edge < b.edge : a.slot < b.slot;
    });
    std::vector<std::uint64_t> open_edges;  // of the open faces, opposite to v
    for (const OpenFace* face : open) {
      const auto& f = face->v;
      open_edges.push_back(v == f[0] ? EdgeKey(f[1], f[2])
                                     : EdgeKey(f[0], v == f[1] ? f[2] : f[1]));
    }
    DisjointSets joined(star.size());
    for (std::size_t i = 0; i + 1 < sides.size(); ++i) {
      if (sides[i].edge != sides[i + 1].edge) continue;
      if (std::find(open_edges.begin(), open_edges.end(), sides[i].edge) != open_edges.end())
        continue;
      joined.Join(sides[i].slot, sides[i + 1].slot);
    }
    std::vector<int> vertex_of(star.size(), -1);
    vertex_of[joined.Find(0)] = v;
    for (std::size_t i = 0; i < star.size(); ++i) {
      const Index r = joined.Find(static_cast<Index>(i));
      if (vertex_of[r] < 0) {
        vertex_of[r] = static_cast<int>(patch.vertices.size());
        patch.vertices.push_back(closed.vertices[v]);
        patch.vertices.back().old_vertex = -1;
        patch.star.emplace_back();
        origin.push_back(v);
        touched.push_back(vertex_of[r]);
        ++duplicated;
      }
      if (vertex_of[r] == v) continue;
      for (int& w : patch.tets[star[i]].v)
        if (w == v) w = vertex_of[r];
      patch.tets[star[i]].changed = true;
      patch.star[vertex_of[r]].push_back(star[i]);
    }
    if (duplicated > 0)
      patch.star[v].erase(std::remove_if(patch.star[v].begin(), patch.star[v].end(),
                                         [&](int t) { return !patch.Has(t, v); }),
                          patch.star[v].end());
  }
};

/// The pieces of a patch, by shared vertices.
class Pieces {
 public:
  explicit Pieces(const CutPatch& patch)
      : joined_(patch.vertices.size()), vertices_(static_cast<int>(patch.vertices.size())) {
    for (const auto& tet : patch.tets)
      for (int k = 1; k < 4; ++k) joined_.Join(tet.v[0], tet.v[k]);
  }
  int Find(int v) { return static_cast<int>(joined_.Find(v)); }
  int Count() {
    int count = 0;
    for (int v = 0; v < vertices_; ++v) count += Find(v) == v;
    return count;
  }

 private:
  DisjointSets joined_;
  int vertices_;
};

/// Pieces that the opening cuts off and that are no more than a few tetrahedra: marks their
/// tetrahedra.
std::vector<char> Chips(const CutPatch& patch, Pieces* pieces) {
  std::vector<double> volume_of(patch.vertices.size(), 0);
  std::vector<char> anchored(patch.vertices.size(), 0);
  double volume = 0;
  for (std::size_t v = 0; v < patch.vertices.size(); ++v)
    if (patch.vertices[v].frozen) anchored[pieces->Find(static_cast<int>(v))] = 1;
  for (const auto& tet : patch.tets) {
    const Vec3 a = patch.vertices[tet.v[0]].rest;
    const double v =
        (patch.vertices[tet.v[1]].rest - a)
            .dot((patch.vertices[tet.v[2]].rest - a).cross(patch.vertices[tet.v[3]].rest - a)) /
        6;
    volume += v;
    volume_of[pieces->Find(tet.v[0])] += v;
  }
  const double small = 3 * volume / double(patch.tets.size());
  std::vector<char> chip(patch.tets.size(), 0);
  for (std::size_t t = 0; t < patch.tets.size(); ++t) {
    const int r = pieces->Find(patch.tets[t].v[0]);
    chip[t] = !anchored[r] && volume_of[r] < small;
  }
  return chip;
}

}  // namespace

std::vector<OpenedFace> OpenedFaces(const CutPatch& patch) {
  constexpr double kSamePlace = 1e-6;  // of the edge length
  struct Side {
    Vec3 middle;
    int tet, corner;
  };
  std::vector<Side> sides;
  for (std::size_t t = 0; t < patch.tets.size(); ++t)
    for (int k = 0; k < 4; ++k)
      if (patch.tets[t].opened >> k & 1) {
        Side side{Vec3::Zero(), static_cast<int>(t), k};
        for (int w : kFaces[k]) side.middle += patch.vertices[patch.tets[t].v[w]].rest / 3;
        sides.push_back(side);
      }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    return a.middle[0] != b.middle[0] ? a.middle[0] < b.middle[0] : a.tet < b.tet;
  });
  std::vector<OpenedFace> faces;
  for (std::size_t i = 0; i < sides.size(); ++i) {
    const auto& v = patch.tets[sides[i].tet].v;
    const double near_mm = kSamePlace * patch.vertices[v[0]].size_mm;
    for (std::size_t j = i + 1;
         j < sides.size() && sides[j].middle[0] <= sides[i].middle[0] + near_mm; ++j) {
      if ((sides[j].middle - sides[i].middle).norm() > near_mm) continue;
      const auto& w = patch.tets[sides[j].tet].v;
      OpenedFace face;
      face.tet_a = sides[i].tet;
      face.tet_b = sides[j].tet;
      int same = 0;
      for (int k = 0; k < 3; ++k) {
        face.a[k] = v[kFaces[sides[i].corner][k]];
        for (int corner : kFaces[sides[j].corner])
          if ((patch.vertices[face.a[k]].rest - patch.vertices[w[corner]].rest).norm() <= near_mm) {
            face.b[k] = w[corner];
            ++same;
          }
      }
      if (same == 3) faces.push_back(face);
    }
  }
  return faces;
}

std::vector<int> TetsToWorkOn(const SurfaceIndex& surface, CutPatch near) {
  for (auto& vertex : near.vertices) vertex.core = true;
  MarkVerticesOnS(surface, &near);
  std::vector<char> work(near.tets.size(), 0);
  for (const auto& face : FacesOnS(surface, near)) work[face.tet[0]] = work[face.tet[1]] = 1;
  for (const CrossedEdge& edge : EdgesCutThrough(surface, near))
    for (int t : near.Around(edge.a, edge.b)) work[t] = 1;
  std::vector<int> tets;
  for (std::size_t t = 0; t < work.size(); ++t)
    if (work[t]) tets.push_back(static_cast<int>(t));
  return tets;
}

SeparationReport OpenFacesOnS(const SurfaceIndex& surface, CutPatch* patch) {
  SeparationReport report;
  std::vector<OpenFace> faces = FacesOnS(surface, *patch);
  while (true) {
    Opening opening(*patch, faces);
    if (opening.duplicated == 0) return report;
    std::vector<char> bad(patch->vertices.size(), 0);
    const bool all_open = report.closed == 0;
    bool any = false;
    std::vector<CutPatch::FanFace> fan;
    for (int v : opening.touched) {
      opening.patch.BoundaryFan(v, &fan);
      if (OneRing(fan)) continue;
      bad[opening.origin[v]] = 1;
      any = true;
      if (all_open) report.pinched.push_back(opening.origin[v]);
    }
    Pieces pieces(opening.patch);
    const int piece_count = pieces.Count();
    const std::vector<char> chip =
        piece_count > 1 ? Chips(opening.patch, &pieces) : std::vector<char>(patch->tets.size(), 0);
    const Index closed_before = report.closed;
    for (OpenFace& face : faces) {
      if (!face.open) continue;
      if (bad[face.v[0]] || bad[face.v[1]] || bad[face.v[2]]) face.open = false;
      if (chip[face.tet[0]] != chip[face.tet[1]]) {
        face.open = false;
        any = true;
      }
      report.closed += !face.open;
    }
    if (any && report.closed == closed_before)
      return report;  // no face left whose closing could mend it: nothing is opened
    if (any) continue;
    for (const OpenFace& face : faces) {
      if (!face.open) continue;
      OpenedFace opened;
      opened.tet_a = face.tet[0];
      opened.tet_b = face.tet[1];
      for (int k = 0; k < 3; ++k) {
        opened.a[k] = opening.CornerOf(face.tet[0], face.v[k]);
        opened.b[k] = opening.CornerOf(face.tet[1], face.v[k]);
      }
      if (opened.a == opened.b) continue;  // at the front: both sides still have the same corners
      for (int k = 0; k < 3 && !report.stuck; ++k) {
        const auto& corner = opening.patch.vertices[opened.a[k]];
        report.stuck = opened.a[k] == opened.b[k] &&
                       !surface.BorderWithin(corner.rest, kFront * corner.size_mm);
      }
      report.faces.push_back(opened);
      report.area_mm2 += face.area_mm2;
      for (int t : face.tet) opening.patch.tets[t].opened |= 1 << CornerOpposite(*patch, t, face.v);
    }
    report.duplicated_vertices = opening.duplicated;
    report.same_pieces = piece_count == Pieces(*patch).Count();
    *patch = std::move(opening.patch);
    return report;
  }
}

}  // namespace kerf
