#include "Cutting/CutRemeshing.h"

#include <algorithm>
#include <cmath>
#include <queue>

#include "Cutting/BoundarySlide.h"

namespace kerf {
namespace {

constexpr double kOnS = 1e-6;  // of the edge length: lies on S already
constexpr double kBentShare =
    0.2;  // an edge that starts on S is cut again only this far from its ends
constexpr double kGrazing = 0.02;                        // of the edge length
constexpr std::array<double, 3> kClear{0.3, 0.2, 0.12};  // of the edge length: not on S
constexpr double kTangentAngle_deg = 35;                 // boundary faces that S grazes

double CosOf(double angle_deg) { return std::cos(angle_deg * M_PI / 180); }

/// Would v on S complete a tetrahedron with all four corners on S?
bool CompletesFlatTet(const CutPatch& patch, int v) {
  for (int t : patch.star[v]) {
    int on = 0;
    for (int w : patch.tets[t].v) on += w != v && patch.vertices[w].on;
    if (on == 3) return true;
  }
  return false;
}

/// Moves v if the tetrahedra around it stay good; puts everything back otherwise.
bool TryMove(const Vec3& to, double worst_allowed, const CutPatch& before, CutPatch* patch, int v) {
  const CutPatch::Vertex old = patch->vertices[v];
  const double current_before = patch->deformed ? patch->WorstCurrentAround(v) : 0;
  patch->vertices[v].rest = to;
  if (patch->WorstCosineAround(v) <= worst_allowed) {
    patch->vertices[v].rest = old.rest;
    patch->Move(v, to, before);
    if (!patch->deformed ||
        patch->WorstCurrentAround(v) <= std::max(CosOf(1.5), std::min(current_before, 1.0)))
      return true;
  }
  patch->vertices[v] = old;
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
  const double worst_allowed = std::max(CosOf(options.keep_angle_deg), patch->WorstCosineAround(v));
  for (double sign : {side < 0 ? -1.0 : 1.0, side < 0 ? 1.0 : -1.0})
    for (double distance : kClear) {
      const Vec3 way = near.point + sign * distance * size * near.normal - patch->vertices[v].rest;
      Vec3 d = way;
      if (slide.OnBoundary() && !slide.Toward(way, &d)) continue;
      if (TryMove(patch->vertices[v].rest + d, worst_allowed, before, patch, v)) return true;
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

constexpr int kEdges[6][2] = {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}};

/// One of the six edges of a tetrahedron.
struct EdgeOfTet {
  std::uint64_t edge;
  int tet, slot;
  int Low() const { return static_cast<int>(edge >> 32); }
  int High() const { return static_cast<int>(edge & 0xFFFFFFFFu); }
};

/// Edges that S may cross, of every tetrahedron; those of the same edge one after the other.
std::vector<EdgeOfTet> EdgesNear(const CutPatch& patch, const std::vector<SurfaceNear>& near) {
  std::vector<EdgeOfTet> edges;
  edges.reserve(2 * patch.tets.size());
  for (std::size_t t = 0; t < patch.tets.size(); ++t) {
    const auto& tet = patch.tets[t];
    for (int slot = 0; slot < 6; ++slot) {
      const int a = tet.v[kEdges[slot][0]], b = tet.v[kEdges[slot][1]];
      if (near[a].triangle < 0 || near[b].triangle < 0) continue;
      // Where S crosses, the two ends are no farther from S than the edge is long.
      const double reach = near[a].distance_mm + near[b].distance_mm;
      if ((patch.vertices[a].rest - patch.vertices[b].rest).squaredNorm() * (1 + 1e-9) <
          reach * reach)
        continue;
      edges.push_back({EdgeKey(a, b), static_cast<int>(t), slot});
    }
  }
  std::sort(edges.begin(), edges.end(),
            [](const EdgeOfTet& a, const EdgeOfTet& b) { return a.edge < b.edge; });
  return edges;
}

std::vector<SurfaceNear> NearOf(const SurfaceIndex& surface, const CutPatch& patch) {
  std::vector<SurfaceNear> near(patch.vertices.size());
  for (std::size_t v = 0; v < near.size(); ++v) {
    if (!patch.vertices[v].core) continue;
    double longest = 0;
    for (int t : patch.star[v])
      for (int w : patch.tets[t].v)
        longest =
            std::max(longest, (patch.vertices[v].rest - patch.vertices[w].rest).squaredNorm());
    near[v] = surface.Closest(patch.vertices[v].rest, std::sqrt(longest));
  }
  return near;
}

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

double CrossingToSplit(const SurfaceIndex& surface, const CutPatch& patch, int a, int b) {
  const auto &va = patch.vertices[a], &vb = patch.vertices[b];
  if ((va.on && vb.on) || (va.frozen && vb.frozen)) return -1;
  std::vector<double> hits;
  surface.Crossings(va.rest, vb.rest, &hits);
  if (!hits.empty() && va.on != vb.on) {
    // S that starts on one end and grazes the other winds about the edge: each cut would leave
    // another such edge behind.
    const double grazing_mm = kGrazing * (va.rest - vb.rest).norm();
    if (surface.Closest((va.on ? vb : va).rest, grazing_mm).triangle >= 0) return -1;
  }
  double best = -1;
  for (double t : hits) {
    if ((va.on && t < kBentShare) || (vb.on && t > 1 - kBentShare)) continue;
    if ((va.on && t > 1 - 0.5 * kBentShare) || (vb.on && t < 0.5 * kBentShare)) continue;
    if (best < 0 || std::abs(t - 0.5) < std::abs(best - 0.5)) best = t;
  }
  return best;
}

void MarkVerticesOnS(const SurfaceIndex& surface, CutPatch* patch) {
  for (auto& vertex : patch->vertices)
    vertex.on = surface.Closest(vertex.rest, kOnS * vertex.size_mm).triangle >= 0;
}

namespace {

std::vector<CrossedEdge> EdgesCutThrough(const SurfaceIndex& surface, const CutPatch& patch,
                                         const std::vector<SurfaceNear>& near) {
  std::vector<CrossedEdge> crossed;
  std::vector<std::array<int, 6>> crossed_of(patch.tets.size());  // 1 + place in `crossed`, or 0
  const std::vector<EdgeOfTet> edges = EdgesNear(patch, near);
  for (std::size_t i = 0; i < edges.size();) {
    const double t = CrossingToSplit(surface, patch, edges[i].Low(), edges[i].High());
    if (t >= 0) crossed.push_back({edges[i].Low(), edges[i].High(), t});
    const std::uint64_t edge = edges[i].edge;
    for (; i < edges.size() && edges[i].edge == edge; ++i)
      if (t >= 0) crossed_of[edges[i].tet][edges[i].slot] = static_cast<int>(crossed.size());
  }
  std::vector<char> through(crossed.size(), 0);
  for (std::size_t t = 0; t < patch.tets.size(); ++t) {
    const auto& v = patch.tets[t].v;
    const auto& places = crossed_of[t];
    if (places == std::array<int, 6>{}) continue;
    if (!patch.vertices[v[0]].core || !patch.vertices[v[1]].core || !patch.vertices[v[2]].core ||
        !patch.vertices[v[3]].core)
      continue;
    bool crosses[4][4] = {};
    for (int slot = 0; slot < 6; ++slot)
      crosses[kEdges[slot][0]][kEdges[slot][1]] = crosses[kEdges[slot][1]][kEdges[slot][0]] =
          places[slot] > 0;
    // Off vertices fall into two sides: crossed edges join different sides, uncrossed ones the
    // same.
    int side[4] = {0, 0, 0, 0};
    int first = -1;
    for (int i = 0; i < 4 && first < 0; ++i)
      if (!patch.vertices[v[i]].on) first = i;
    if (first < 0) continue;
    for (int i = 0; i < 4; ++i)
      if (!patch.vertices[v[i]].on) side[i] = i == first || !crosses[first][i] ? 1 : -1;
    bool consistent = true;
    for (int i = 0; i < 4; ++i)
      for (int k = i + 1; k < 4; ++k)
        if (side[i] != 0 && side[k] != 0)
          consistent = consistent && (side[i] != side[k]) == crosses[i][k];
    if (!consistent) continue;
    for (int place : places)
      if (place > 0) through[place - 1] = 1;
  }
  std::vector<CrossedEdge> out;
  for (std::size_t i = 0; i < crossed.size(); ++i)
    if (through[i]) out.push_back(crossed[i]);
  return out;
}

}  // namespace

std::vector<CrossedEdge> EdgesCutThrough(const SurfaceIndex& surface, const CutPatch& patch) {
  return EdgesCutThrough(surface, patch, NearOf(surface, patch));
}

Index SnapVertices(const SurfaceIndex& surface, const RemeshingOptions& options,
                   const CutPatch& before, CutPatch* patch) {
  MarkVerticesOnS(surface, patch);
  std::vector<char> off(patch->vertices.size(), 0);
  for (int v : options.off)
    if (!patch->vertices[v].frozen && MoveOff(surface, options, before, patch, v)) {
      off[v] = 1;
      patch->vertices[v].on = false;
    }
  const auto near = NearOf(surface, *patch);
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
  for (std::size_t v = 0; v < near.size(); ++v) {
    const auto& vertex = patch->vertices[v];
    if (near[v].triangle < 0 || vertex.on) continue;
    if (near[v].distance_mm <= 0.02 * vertex.size_mm)
      add(static_cast<int>(v), near[v].distance_mm / vertex.size_mm, -1);
  }
  for (const auto& [a, b, t] : EdgesCutThrough(surface, *patch, near)) {
    if (patch->vertices[a].on || patch->vertices[b].on) continue;
    if (t <= options.snap_fraction) add(a, t, b);
    if (1 - t <= options.snap_fraction) add(b, 1 - t, a);
  }
  std::sort(candidates.begin(), candidates.end());
  Index moved = 0;
  for (const Candidate& c : candidates) {
    auto& vertex = patch->vertices[c.v];
    if (vertex.frozen || vertex.on || off[c.v]) continue;
    const bool all_across_on =
        !c.across.empty() &&
        std::all_of(c.across.begin(), c.across.end(), [&](int w) { return patch->vertices[w].on; });
    if (all_across_on || CompletesFlatTet(*patch, c.v)) continue;
    const double worst_allowed =
        std::max(CosOf(options.keep_angle_deg), patch->WorstCosineAround(c.v));
    bool done = false;
    for (const Vec3& place : PlacesOnS(surface, options, *patch, c.v, near[c.v]))
      if (!done && TryMove(place, worst_allowed, before, patch, c.v)) done = true;
    moved += done;
    if (!done) {
      const double distance = near[c.v].distance_mm;
      done = distance <= options.accept_fraction * vertex.size_mm;
      if (!done && distance <= options.snap_fraction * vertex.size_mm) {
        const BoundarySlide slide(*patch, c.v, 0);
        done = slide.OnBoundary() && slide.ParallelTo(near[c.v].normal, kTangentAngle_deg);
      }
    }
    vertex.on = done;
  }
  return moved;
}

bool SplitCrossedEdges(const SurfaceIndex& surface, CutPatch* patch) {
  struct Job {
    double length;
    int a, b;
    bool operator<(const Job& o) const {  // longest first
      return length != o.length ? length < o.length : a != o.a ? a > o.a : b > o.b;
    }
  };
  std::priority_queue<Job> jobs;
  auto add = [&](int a, int b) {
    const double t = CrossingToSplit(surface, *patch, a, b);
    if (t >= 0)
      jobs.push({(patch->vertices[a].rest - patch->vertices[b].rest).norm(), std::min(a, b),
                 std::max(a, b)});
  };
  for (const CrossedEdge& e : EdgesCutThrough(surface, *patch)) add(e.a, e.b);
  const std::size_t limit = 4 * patch->vertices.size() + 64;
  while (!jobs.empty()) {
    if (patch->vertices.size() >= limit) return false;
    const Job job = jobs.top();
    jobs.pop();
    if (patch->Around(job.a, job.b).empty()) continue;
    const double t = CrossingToSplit(surface, *patch, job.a, job.b);
    if (t < 0) continue;
    const Vec3 at = (1 - t) * patch->vertices[job.a].rest + t * patch->vertices[job.b].rest;
    const int m = patch->SplitEdge(job.a, job.b, at);
    patch->vertices[m].on = true;
    for (int w : patch->Neighbors(m))
      if (!patch->vertices[w].on) add(m, w);
  }
  return true;
}

namespace {

/// Would S cross an edge at v in this place that it does not cross now?
bool ComesToCross(const SurfaceIndex& surface, const CutPatch& patch, int v, const Vec3& place) {
  if (patch.vertices[v].on) return false;
  std::vector<double> hits;
  for (int w : patch.Neighbors(v)) {
    if (patch.vertices[w].on) continue;
    surface.Crossings(place, patch.vertices[w].rest, &hits);
    if (hits.empty()) continue;
    surface.Crossings(patch.vertices[v].rest, patch.vertices[w].rest, &hits);
    if (hits.empty()) return true;
  }
  return false;
}

}  // namespace

void ImprovePatch(const SurfaceIndex& surface, const RemeshingOptions& options,
                  const CutPatch& before, CutPatch* patch) {
  const double goal = CosOf(options.goal_angle_deg);
  for (int round = 0; round < options.improvement_rounds; ++round) {
    std::vector<std::pair<double, int>> bad;
    for (std::size_t t = 0; t < patch->tets.size(); ++t)
      if (patch->tets[t].changed) {
        const double worst = patch->WorstCosine(static_cast<int>(t));
        if (worst > goal) bad.push_back({-worst, static_cast<int>(t)});
      }
    if (bad.empty()) return;
    std::sort(bad.begin(), bad.end());
    bool improved = false;
    for (const auto& [key, t] : bad) {
      for (int v : std::array<int, 4>(patch->tets[t].v)) {
        if (patch->WorstCosine(t) <= goal) break;
        if (patch->vertices[v].frozen) continue;
        const double h = patch->vertices[v].size_mm;
        const BoundarySlide slide(*patch, v, 0.25 * options.slide_tolerance * h);
        const bool on = patch->vertices[v].on;
        Vec3 middle = Vec3::Zero();
        const auto neighbors = patch->Neighbors(v);
        for (int w : neighbors) middle += patch->vertices[w].rest / double(neighbors.size());
        for (double step : {0.3, 0.15, 0.06}) {
          double best = patch->WorstCosineAround(v);
          const Vec3 from = patch->vertices[v].rest;
          Vec3 best_place = from;
          std::array<Vec3, 7> ways{Vec3::UnitX(),      -Vec3::UnitX(), Vec3::UnitY(),
                                   -Vec3::UnitY(),     Vec3::UnitZ(),  -Vec3::UnitZ(),
                                   (middle - from) / h};
          for (const Vec3& way : ways) {
            Vec3 d = step * h * way;
            if (slide.OnBoundary()) d = slide.Project(d);
            Vec3 place = from + d;
            if (on) {
              const SurfaceNear near = surface.Closest(place, h);
              if (near.triangle < 0 || near.on_border) continue;
              if (!slide.OnBoundary()) {
                place = near.point;
              } else if (near.distance_mm > 1e-9 * h) {
                Vec3 back;
                if (!slide.Toward(near.point - place, &back)) continue;
                place += back;
                if (surface.Closest(place, h).distance_mm > 0.01 * h) continue;
              }
            }
            if (slide.OnBoundary() && !slide.Allowed(place - from)) continue;
            patch->vertices[v].rest = place;
            const double worst = patch->WorstCosineAround(v);
            if (worst < best - 1e-6) {
              best = worst;
              best_place = place;
            }
          }
          patch->vertices[v].rest = from;
          if (best_place != from && !ComesToCross(surface, *patch, v, best_place) &&
              TryMove(best_place, best + 1e-9, before, patch, v))
            improved = true;
        }
      }
    }
    if (!improved) return;
  }
}

}  // namespace kerf
