#include "Cutting/CrossedEdges.h"

#include <algorithm>
#include <cmath>
#include <queue>

namespace kerf {
namespace {

constexpr double kBentShare =
    0.2;  // an edge that starts on S is cut again only this far from its ends
constexpr double kGrazing = 0.02;  // of the edge length
constexpr int kEdges[6][2] = {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}};

/// One of the six edges of a tetrahedron of the core.
struct EdgeOfTet {
  std::uint64_t edge;
  int place, slot;  // place: in CoreNear::Tets()
  int Low() const { return static_cast<int>(edge >> 32); }
  int High() const { return static_cast<int>(edge & 0xFFFFFFFFu); }
};

/// Edges that S may cross; those of the same edge one after the other.
std::vector<EdgeOfTet> EdgesNear(const CutPatch& patch, const CoreNear& near) {
  std::vector<EdgeOfTet> edges;
  edges.reserve(6 * near.Tets().size());
  for (std::size_t place = 0; place < near.Tets().size(); ++place) {
    const auto& v = patch.tets[near.Tets()[place]].v;
    for (int slot = 0; slot < 6; ++slot) {
      const int a = v[kEdges[slot][0]], b = v[kEdges[slot][1]];
      if (near[a].triangle < 0 || near[b].triangle < 0) continue;
      const bool on_a = patch.vertices[a].on, on_b = patch.vertices[b].on;
      if (on_a && on_b) continue;
      // Where S crosses, the two ends are no farther from S than the edge is long.
      const double reach = on_a   ? near[b].distance_mm / (1 - kBentShare)
                           : on_b ? near[a].distance_mm / (1 - kBentShare)
                                  : near[a].distance_mm + near[b].distance_mm;
      if ((patch.vertices[a].rest - patch.vertices[b].rest).squaredNorm() * (1 + 1e-9) <
          reach * reach)
        continue;
      edges.push_back({EdgeKey(a, b), static_cast<int>(place), slot});
    }
  }
  std::sort(edges.begin(), edges.end(),
            [](const EdgeOfTet& a, const EdgeOfTet& b) { return a.edge < b.edge; });
  return edges;
}

/// Does S cut through the tetrahedron? The corners off S fall into two sides: crossed edges join
/// different sides, all others the same.
bool CutsThrough(const CutPatch& patch, const std::array<int, 4>& v,
                 const std::array<int, 6>& crossed) {
  bool crosses[4][4] = {};
  for (int slot = 0; slot < 6; ++slot)
    crosses[kEdges[slot][0]][kEdges[slot][1]] = crosses[kEdges[slot][1]][kEdges[slot][0]] =
        crossed[slot] > 0;
  int side[4] = {0, 0, 0, 0};
  int first = -1;
  for (int i = 0; i < 4 && first < 0; ++i)
    if (!patch.vertices[v[i]].on) first = i;
  if (first < 0) return false;
  for (int i = 0; i < 4; ++i)
    if (!patch.vertices[v[i]].on) side[i] = i == first || !crosses[first][i] ? 1 : -1;
  for (int i = 0; i < 4; ++i)
    for (int k = i + 1; k < 4; ++k)
      if (side[i] != 0 && side[k] != 0 && (side[i] != side[k]) != crosses[i][k]) return false;
  return true;
}

}  // namespace

double CrossingToSplit(const SurfaceIndex& surface, const CutPatch& patch, int a, int b) {
  const auto &va = patch.vertices[a], &vb = patch.vertices[b];
  if ((va.on && vb.on) || (va.frozen && vb.frozen)) return -1;
  const double from = va.on ? kBentShare : vb.on ? 0.5 * kBentShare : 0;
  const double to = va.on ? 1 - 0.5 * kBentShare : vb.on ? 1 - kBentShare : 1;
  std::vector<double> hits;
  surface.Crossings(va.rest, vb.rest, &hits, from, to);
  double best = -1;
  for (double t : hits) {
    if (t < from || t > to) continue;
    if (best < 0 || std::abs(t - 0.5) < std::abs(best - 0.5)) best = t;
  }
  if (best >= 0 && va.on != vb.on) {
    // S that starts on one end and grazes the other winds about the edge: each cut would leave
    // another such edge behind.
    const double grazing_mm = kGrazing * (va.rest - vb.rest).norm();
    if (surface.Closest((va.on ? vb : va).rest, grazing_mm).triangle >= 0) return -1;
  }
  return best;
}

std::vector<CrossedEdge> EdgesCutThrough(const SurfaceIndex& surface, const CutPatch& patch,
                                         const CoreNear& near) {
  std::vector<CrossedEdge> crossed;
  std::vector<std::array<int, 6>> crossed_of(near.Tets().size());  // 1 + place in `crossed`, or 0
  const std::vector<EdgeOfTet> edges = EdgesNear(patch, near);
  for (std::size_t i = 0; i < edges.size();) {
    const double t = CrossingToSplit(surface, patch, edges[i].Low(), edges[i].High());
    if (t >= 0) crossed.push_back({edges[i].Low(), edges[i].High(), t});
    const std::uint64_t edge = edges[i].edge;
    for (; i < edges.size() && edges[i].edge == edge; ++i)
      if (t >= 0) crossed_of[edges[i].place][edges[i].slot] = static_cast<int>(crossed.size());
  }
  std::vector<char> through(crossed.size(), 0);
  for (std::size_t place = 0; place < crossed_of.size(); ++place) {
    if (crossed_of[place] == std::array<int, 6>{} ||
        !CutsThrough(patch, patch.tets[near.Tets()[place]].v, crossed_of[place]))
      continue;
    for (int number : crossed_of[place])
      if (number > 0) through[number - 1] = 1;
  }
  std::vector<CrossedEdge> out;
  for (std::size_t i = 0; i < crossed.size(); ++i)
    if (through[i]) out.push_back(crossed[i]);
  return out;
}

bool SplitCrossedEdges(const SurfaceIndex& surface, const CoreNear& near, std::size_t most_vertices,
                       CutPatch* patch) {
  struct Job {
    double length;
    CrossedEdge edge;
    bool operator<(const Job& o) const {  // longest first
      return length != o.length   ? length < o.length
             : edge.a != o.edge.a ? edge.a > o.edge.a
                                  : edge.b > o.edge.b;
    }
  };
  std::priority_queue<Job> jobs;
  auto add = [&](const CrossedEdge& edge) {
    if (edge.t >= 0)
      jobs.push({(patch->vertices[edge.a].rest - patch->vertices[edge.b].rest).norm(), edge});
  };
  for (const CrossedEdge& edge : EdgesCutThrough(surface, *patch, near)) add(edge);
  while (!jobs.empty()) {
    if (patch->vertices.size() >= most_vertices) return false;
    const CrossedEdge job = jobs.top().edge;
    jobs.pop();
    if (patch->Around(job.a, job.b).empty()) continue;
    const Vec3 at = (1 - job.t) * patch->vertices[job.a].rest + job.t * patch->vertices[job.b].rest;
    const int m = patch->SplitEdge(job.a, job.b, at);
    patch->vertices[m].on = true;
    for (int w : patch->Neighbors(m))  // all of them older: w < m
      if (!patch->vertices[w].on) add({w, m, CrossingToSplit(surface, *patch, w, m)});
  }
  return true;
}

}  // namespace kerf
