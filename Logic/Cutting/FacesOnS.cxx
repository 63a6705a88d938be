#include "Cutting/FacesOnS.h"

#include <algorithm>
#include <cmath>

namespace kerf {
namespace {

constexpr double kBeyondBorder = 0.15;  // of the face's longest edge
constexpr double kBesideS = 0.35;
constexpr double kParallel = 0.3;  // cosine
constexpr double kExact = 1e-6;    // of the face's longest edge, and of 1 as a cosine

struct Touch {
  std::array<int, 3> v;
  int tet;
  bool operator<(const Touch& o) const {
    for (int k = 0; k < 3; ++k)
      if (v[k] != o.v[k]) return v[k] < o.v[k];
    return tet < o.tet;
  }
};

Vec3 Middle(const CutPatch& patch, int t) {
  Vec3 middle = Vec3::Zero();
  for (int w : patch.tets[t].v) middle += patch.vertices[w].rest / 4;
  return middle;
}

/// The side of S that a tetrahedron lies on: by its corners away from the face, by its middle where
/// they are on S too.
double SideOf(const CutPatch& patch, int t, const std::array<int, 3>& face, const SurfaceNear& near,
              const SurfaceIndex& surface) {
  const int o = patch.tets[t].v[CornerOpposite(patch, t, face)];
  if (!patch.vertices[o].on) return (patch.vertices[o].rest - near.point).dot(near.normal);
  const Vec3 middle = Middle(patch, t);
  const SurfaceNear at = surface.Closest(middle, 1e300);
  return (middle - at.point).dot(near.normal);
}

}  // namespace

int CornerOpposite(const CutPatch& patch, int t, const std::array<int, 3>& face) {
  for (int k = 0; k < 3; ++k) {
    const int w = patch.tets[t].v[k];
    if (w != face[0] && w != face[1] && w != face[2]) return k;
  }
  return 3;
}

std::vector<FaceOnS> FacesOnS(const SurfaceIndex& surface, const CutPatch& patch) {
  std::vector<Touch> touches;
  for (std::size_t t = 0; t < patch.tets.size(); ++t) {
    const auto& v = patch.tets[t].v;
    std::array<bool, 4> on;
    for (int k = 0; k < 4; ++k) on[k] = patch.vertices[v[k]].on && !patch.vertices[v[k]].frozen;
    if (on[0] + on[1] + on[2] + on[3] < 3) continue;
    for (const auto& f : kFaces) {
      if (!on[f[0]] || !on[f[1]] || !on[f[2]]) continue;
      Touch touch{{v[f[0]], v[f[1]], v[f[2]]}, static_cast<int>(t)};
      std::sort(touch.v.begin(), touch.v.end());
      touches.push_back(touch);
    }
  }
  std::sort(touches.begin(), touches.end());
  struct Found {
    FaceOnS face;
    SurfaceNear near;
    bool exact;  // a part of S itself: it has tissue on both sides of S
    bool steep;  // across S, as over the inside of a fold
  };
  std::vector<Found> found;
  std::vector<char> exact_faces(patch.tets.size(), 0);
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
    const double cosine = std::abs(normal.normalized().dot(near.normal));
    const bool exact = near.distance_mm < kExact * longest && cosine > 1 - kExact;
    found.push_back({{v, {touches[i].tet, touches[i + 1].tet}, 0.5 * normal.norm()},
                     near,
                     exact,
                     cosine < kParallel});
    if (exact)
      for (int t : found.back().face.tet) ++exact_faces[t];
  }
  std::vector<FaceOnS> faces;
  std::vector<double> hits;
  for (const auto& [face, near, exact, steep] : found) {
    if (!exact) {
      const auto [t, u] = face.tet;
      if (SideOf(patch, t, face.v, near, surface) * SideOf(patch, u, face.v, near, surface) >= 0)
        continue;
      // In a fold of S, which lies on several faces of the tetrahedron, the nearest place of S does
      // not tell the side: is S between the two tetrahedra?
      if (steep || exact_faces[t] > 1 || exact_faces[u] > 1) {
        surface.Crossings(Middle(patch, t), Middle(patch, u), &hits);
        if (hits.empty()) continue;
      }
    }
    faces.push_back(face);
  }
  return faces;
}

}  // namespace kerf
