#include "Cutting/SnapVertices.h"

#include <algorithm>
#include <cmath>

#include "Cutting/BoundarySlide.h"
#include "Cutting/CrossedEdges.h"

namespace kerf {
namespace {

constexpr std::array<double, 3> kClear{0.3, 0.2, 0.12};  // of the edge length: not on S
constexpr double kTangentAngle_deg = 35;                 // boundary faces that S grazes

/// Would v on S complete a tetrahedron with all four corners on S?
bool CompletesFlatTet(const CutPatch& patch, int v) {
  for (int t : patch.star[v]) {
    int on = 0;
    for (int w : patch.tets[t].v) on += w != v && patch.vertices[w].on;
    if (on == 3) return true;
  }
  return false;
}

/// Moves v away from S, to the side that its boundary faces are on: an open cut that would touch S
/// in this one vertex ends before it. @return whether it could be moved
bool MoveOff(const SurfaceIndex& surface, const RemeshingOptions& options, const CutPatch& before,
             CutPatch* patch, int v) {
  const double size = patch->vertices[v].size_mm;
  const SurfaceNear near = surface.Closest(patch->vertices[v].rest, kClear.front() * size);
  if (near.triangle < 0) return true;
  std::vector<CutPatch::FanFace> fan;
  patch->BoundaryFan(v, &fan);
  double side = 0;
  for (const CutPatch::FanFace& face : fan)
    for (int w : face) side += (patch->vertices[w].rest - near.point).dot(near.normal);
  const BoundarySlide slide(*patch, v, options.slide_tolerance * size);
  const double worst_allowed =
      std::max(CosineOf(options.keep_angle_deg), patch->WorstCosineAround(v));
  for (double sign : {side < 0 ? -1.0 : 1.0, side < 0 ? 1.0 : -1.0})
    for (double distance : kClear) {
      const Vec3 way = near.point + sign * distance * size * near.normal - patch->vertices[v].rest;
      Vec3 d = way;
      if (slide.OnBoundary() && !slide.Toward(way, &d)) continue;
      if (patch->TryMove(v, patch->vertices[v].rest + d, worst_allowed, before)) return true;
    }
  return false;
}

struct Candidate {
  double fraction;
  int v;
  std::vector<int> across;
  bool operator<(const Candidate& o) const {
    return fraction != o.fraction ? fraction < o.fraction : v < o.v;
  }
};

/// Places on S that v can go to, best first.
std::vector<Vec3> PlacesOnS(const SurfaceIndex& surface, const RemeshingOptions& options,
                            const CutPatch& patch, int v, const SurfaceNear& near) {
  std::vector<Vec3> places;
  const auto& vertex = patch.vertices[v];
  const BoundarySlide slide(patch, v, options.slide_tolerance * vertex.size_mm);
  if (!slide.OnBoundary()) {
    places.push_back(near.point);
    return places;
  }
  Vec3 at = vertex.rest;
  for (int step = 0; step < 4; ++step) {
    const SurfaceNear here = surface.Closest(at, vertex.size_mm);
    if (here.triangle < 0) return places;
    if (here.distance_mm < 1e-4 * vertex.size_mm) break;
    Vec3 d;
    if (!slide.Toward(here.point - at, &d)) return places;
    at += d;
  }
  const SurfaceNear reached = surface.Closest(at, vertex.size_mm);
  if (reached.triangle >= 0 && reached.distance_mm < 0.01 * vertex.size_mm &&
      slide.Allowed(at - vertex.rest) && (at - vertex.rest).norm() < 0.6 * vertex.size_mm)
    places.push_back(at);
  return places;
}

}  // namespace

Index SnapVertices(const SurfaceIndex& surface, const RemeshingOptions& options,
                   const CutPatch& before, CoreNear* core_near, CutPatch* patch) {
  CoreNear& near = *core_near;
  std::vector<char> off(patch->vertices.size(), 0);
  std::vector<int> moved_vertices;
  for (int v : options.off)
    if (!patch->vertices[v].frozen && MoveOff(surface, options, before, patch, v)) {
      off[v] = 1;
      patch->vertices[v].on = false;
      moved_vertices.push_back(v);
    }
  near.Update(surface, *patch, moved_vertices);
  moved_vertices.clear();
  std::vector<Candidate> candidates;
  std::vector<int> candidate_of(patch->vertices.size(), -1);
  auto add = [&](int v, double fraction, int across) {
    if (candidate_of[v] < 0) {
      candidate_of[v] = static_cast<int>(candidates.size());
      candidates.push_back({fraction, v, {}});
    }
    Candidate& c = candidates[candidate_of[v]];
    c.fraction = std::min(c.fraction, fraction);
    if (across >= 0) c.across.push_back(across);
  };
  for (int v = 0; v < static_cast<int>(patch->vertices.size()); ++v) {
    const auto& vertex = patch->vertices[v];
    if (near[v].triangle < 0 || vertex.on) continue;
    if (near[v].distance_mm <= 0.02 * vertex.size_mm)
      add(v, near[v].distance_mm / vertex.size_mm, -1);
  }
  for (const auto& [a, b, t] : EdgesCutThrough(surface, *patch, near)) {
    if (patch->vertices[a].on || patch->vertices[b].on) continue;
    if (t <= options.snap_fraction) add(a, t, b);
    if (1 - t <= options.snap_fraction) add(b, 1 - t, a);
  }
  std::sort(candidates.begin(), candidates.end());
  for (const Candidate& c : candidates) {
    auto& vertex = patch->vertices[c.v];
    if (vertex.frozen || vertex.on || off[c.v]) continue;
    const bool all_across_on =
        !c.across.empty() &&
        std::all_of(c.across.begin(), c.across.end(), [&](int w) { return patch->vertices[w].on; });
    if (all_across_on || CompletesFlatTet(*patch, c.v)) continue;
    const double worst_allowed =
        std::max(CosineOf(options.keep_angle_deg), patch->WorstCosineAround(c.v));
    bool done = false;
    for (const Vec3& place : PlacesOnS(surface, options, *patch, c.v, near[c.v]))
      if (!done && patch->TryMove(c.v, place, worst_allowed, before)) done = true;
    if (done) {
      moved_vertices.push_back(c.v);
    } else {
      const double distance = near[c.v].distance_mm;
      done = distance <= options.accept_fraction * vertex.size_mm;
      if (!done && distance <= options.snap_fraction * vertex.size_mm) {
        const BoundarySlide slide(*patch, c.v, 0);
        done = slide.OnBoundary() && slide.ParallelTo(near[c.v].normal, kTangentAngle_deg);
      }
    }
    vertex.on = done;
  }
  near.Update(surface, *patch, moved_vertices);
  return static_cast<Index>(moved_vertices.size());
}

}  // namespace kerf
