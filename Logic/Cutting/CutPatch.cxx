#include "Cutting/CutPatch.h"

#include <algorithm>
#include <cmath>

namespace kerf {
namespace {

constexpr double kInside = -1e-12;  // a weight of a point that a tetrahedron holds

}  // namespace

double CosineOf(double angle_deg) { return std::cos(angle_deg * M_PI / 180); }

double CosineOfSmallestDihedral(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const Vec3 ab = b - a, ac = c - a, ad = d - a;
  const Vec3 nd = ac.cross(ab), nb = ad.cross(ac), nc = ab.cross(ad);  // outward
  const Vec3 na = -(nb + nc + nd);
  if (!(ab.dot(ac.cross(ad)) > 0)) return 2;
  const double la = na.norm(), lb = nb.norm(), lc = nc.norm(), ld = nd.norm();
  double worst = -na.dot(nb) / (la * lb);
  worst = std::max(worst, -na.dot(nc) / (la * lc));
  worst = std::max(worst, -na.dot(nd) / (la * ld));
  worst = std::max(worst, -nb.dot(nc) / (lb * lc));
  worst = std::max(worst, -nb.dot(nd) / (lb * ld));
  worst = std::max(worst, -nc.dot(nd) / (lc * ld));
  return worst == worst ? worst : 2;
}

bool AllAnglesAbove(double cosine, const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const Vec3 ab = b - a, ac = c - a, ad = d - a;
  const Vec3 nb = ad.cross(ac), nc = ab.cross(ad), nd = ac.cross(ab);
  const Vec3 na = -(nb + nc + nd);
  if (!(ab.dot(nb) < 0)) return false;
  const double limit = cosine * cosine * (1 - 1e-9);
  const double la = na.squaredNorm(), lb = nb.squaredNorm(), lc = nc.squaredNorm(),
               ld = nd.squaredNorm();
  const auto above = [limit](double product, double length2) {
    return product >= 0 || product * product < limit * length2;
  };
  return above(na.dot(nb), la * lb) && above(na.dot(nc), la * lc) && above(na.dot(nd), la * ld) &&
         above(nb.dot(nc), lb * lc) && above(nb.dot(nd), lb * ld) && above(nc.dot(nd), lc * ld);
}

CutPatch::CutPatch(const TetMesh& mesh, const Points* positions, const std::vector<Index>& chosen,
                   const std::vector<char>& inner) {
  deformed = positions != nullptr;
  std::vector<int> local(mesh.VertexCount(), -1);
  tets.reserve(2 * chosen.size());
  old_tet = chosen;
  for (Index t : chosen) {
    Tet tet;
    tet.source = static_cast<int>(tets.size());
    tet.region = mesh.region[t];
    for (int k = 0; k < 4; ++k) {
      const Index v = mesh.tets(t, k);
      if (local[v] < 0) {
        local[v] = static_cast<int>(vertices.size());
        Vertex vertex;
        vertex.rest = mesh.rest.row(v).transpose();
        vertex.current = positions ? Vec3(positions->row(v).transpose()) : vertex.rest;
        vertex.old_vertex = v;
        vertex.frozen = !inner[v];
        vertices.push_back(vertex);
      }
      tet.v[k] = local[v];
    }
    tets.push_back(tet);
  }
  std::vector<int> count(vertices.size(), 0);
  for (const Tet& tet : tets)
    for (int v : tet.v) ++count[v];
  star.Reserve(2 * vertices.size(), 8 * tets.size());
  for (int tets_of_vertex : count) star.Add(tets_of_vertex + 4);
  std::fill(count.begin(), count.end(), 0);
  for (std::size_t t = 0; t < tets.size(); ++t) {
    const auto& v = tets[t].v;
    double length[4][4];
    for (int k = 0; k < 4; ++k)
      for (int j = k + 1; j < 4; ++j)
        length[k][j] = length[j][k] = (vertices[v[k]].rest - vertices[v[j]].rest).norm();
    for (int k = 0; k < 4; ++k) {
      star.Push(v[k], static_cast<int>(t));
      for (int j = 0; j < 4; ++j)
        if (j != k) vertices[v[k]].size_mm += length[k][j];
      count[v[k]] += 3;
    }
  }
  for (std::size_t v = 0; v < vertices.size(); ++v) vertices[v].size_mm /= count[v];
}

std::vector<int> CutPatch::TetsOutOf(const std::vector<Index>& tets_of_mesh) const {
  std::vector<int> out;
  for (std::size_t t = 0; t < tets.size(); ++t)
    if (std::binary_search(tets_of_mesh.begin(), tets_of_mesh.end(), old_tet[tets[t].source]))
      out.push_back(static_cast<int>(t));
  return out;
}

void CutPatch::MarkCore(const std::vector<int>& of_tets) {
  for (Vertex& vertex : vertices) vertex.core = false;
  for (int t : of_tets)
    for (int v : tets[t].v) vertices[v].core = true;
}

void CutPatch::FacesAt(int v, std::vector<FaceAt>* faces) const {
  // The corners of the three faces at a corner, from it on.
  constexpr int kFan[4][3][2] = {{{3, 2}, {1, 3}, {2, 1}},
                                 {{2, 3}, {3, 0}, {0, 2}},
                                 {{3, 1}, {0, 3}, {1, 0}},
                                 {{1, 2}, {2, 0}, {0, 1}}};
  constexpr std::size_t kSmall = 256;
  const ShortLists::List around = star[v];
  std::size_t slots = kSmall;
  while (slots < 6 * std::size_t(around.size())) slots *= 2;
  std::array<int, kSmall> small;
  std::vector<int> large(slots > kSmall ? slots : 0);
  int* const table = slots > kSmall ? large.data() : small.data();  // 1 + place in `faces`, or 0
  std::fill_n(table, slots, 0);
  faces->clear();
  for (int i = 0; i < around.size(); ++i) {
    const auto& corners = tets[around[i]].v;
    const int corner = v == corners[0] ? 0 : v == corners[1] ? 1 : v == corners[2] ? 2 : 3;
    for (const auto& ends : kFan[corner]) {
      const int a = corners[ends[0]], b = corners[ends[1]];
      const std::uint64_t edge = EdgeKey(a, b);
      std::size_t at = (edge * 0x9E3779B97F4A7C15u >> 32) & (slots - 1);
      while (table[at] > 0 && (*faces)[table[at] - 1].edge != edge) at = (at + 1) & (slots - 1);
      if (table[at] > 0) {
        (*faces)[table[at] - 1].other = i;
      } else {
        faces->push_back({edge, {a, b}, i, -1});
        table[at] = static_cast<int>(faces->size());
      }
    }
  }
}

void CutPatch::BoundaryFan(int v, std::vector<FanFace>* fan) const {
  std::vector<FaceAt> faces;
  FacesAt(v, &faces);
  faces.erase(std::remove_if(faces.begin(), faces.end(),
                             [](const FaceAt& face) { return face.other >= 0; }),
              faces.end());
  std::sort(faces.begin(), faces.end(),
            [](const FaceAt& a, const FaceAt& b) { return a.edge < b.edge; });
  fan->clear();
  for (const FaceAt& face : faces) fan->push_back(face.ends);
}

std::vector<int> CutPatch::Around(int a, int b) const {
  std::vector<int> around;
  for (int t : star[a])
    if (Has(t, b)) around.push_back(t);
  return around;
}

std::vector<int> CutPatch::Neighbors(int v) const {
  std::vector<int> neighbors;
  neighbors.reserve(3 * star[v].size());
  for (int t : star[v])
    for (int w : tets[t].v)
      if (w != v) neighbors.push_back(w);
  std::sort(neighbors.begin(), neighbors.end());
  neighbors.erase(std::unique(neighbors.begin(), neighbors.end()), neighbors.end());
  return neighbors;
}

double CutPatch::WorstCosine(int t) const {
  const auto& v = tets[t].v;
  return CosineOfSmallestDihedral(vertices[v[0]].rest, vertices[v[1]].rest, vertices[v[2]].rest,
                                  vertices[v[3]].rest);
}

double CutPatch::WorstCosineCurrent(int t) const {
  const auto& v = tets[t].v;
  return CosineOfSmallestDihedral(vertices[v[0]].current, vertices[v[1]].current,
                                  vertices[v[2]].current, vertices[v[3]].current);
}

double CutPatch::WorstCosineAround(int v) const {
  double worst = -1;
  for (int t : star[v]) worst = std::max(worst, WorstCosine(t));
  return worst;
}

double CutPatch::WorstCurrentAround(int v) const {
  double worst = -1;
  for (int t : star[v]) worst = std::max(worst, WorstCosineCurrent(t));
  return worst;
}

double CutPatch::Volume_mm3(int t) const {
  const auto& v = tets[t].v;
  const Vec3& a = vertices[v[0]].rest;
  return (vertices[v[1]].rest - a).dot((vertices[v[2]].rest - a).cross(vertices[v[3]].rest - a)) /
         6;
}

int CutPatch::SplitEdge(int a, int b, const Vec3& at) {
  const int m = static_cast<int>(vertices.size());
  const Vec3 ab = vertices[b].rest - vertices[a].rest;
  const double t = std::clamp((at - vertices[a].rest).dot(ab) / ab.squaredNorm(), 0.0, 1.0);
  Vertex vertex;
  vertex.rest = (1 - t) * vertices[a].rest + t * vertices[b].rest;
  vertex.current = (1 - t) * vertices[a].current + t * vertices[b].current;
  vertex.core = true;
  vertex.size_mm = 0.5 * (vertices[a].size_mm + vertices[b].size_mm);
  vertices.push_back(vertex);
  star.Add(16);
  for (int old : Around(a, b)) {
    Tet half = tets[old];
    for (int k = 0; k < 4; ++k) {  // the face between the halves is a new one
      if (half.v[k] == a) {
        half.v[k] = m;
        tets[old].opened &= ~(1 << k);
      } else if (half.v[k] == b) {
        tets[old].v[k] = m;
        half.opened &= ~(1 << k);
      }
    }
    const int fresh = static_cast<int>(tets.size());
    half.changed = tets[old].changed = true;
    tets.push_back(half);
    star.RemoveIf(b, [old](int t) { return t == old; });
    for (int x : half.v)
      if (x != m) star.Push(x, fresh);
    star.Push(m, old);
    star.Push(m, fresh);
  }
  return m;
}

void CutPatch::Move(int v, const Vec3& to, const CutPatch& before) {
  if (deformed) {
    std::vector<int> sources;
    for (int t : star[v]) sources.push_back(tets[t].source);
    Vec4 weights;
    const int holder = before.Locate(to, sources, &weights);
    vertices[v].current = before.CurrentOf(holder, weights);
  }
  vertices[v].rest = to;
  vertices[v].moved = true;
  for (int t : star[v]) tets[t].changed = true;
}

bool CutPatch::TryMove(int v, const Vec3& to, double worst_allowed, const CutPatch& before) {
  const Vertex old = vertices[v];
  const double current_before = deformed ? WorstCurrentAround(v) : 0;
  vertices[v].rest = to;
  if (WorstCosineAround(v) <= worst_allowed) {
    vertices[v].rest = old.rest;
    Move(v, to, before);
    if (!deformed ||
        WorstCurrentAround(v) <= std::max(CosineOf(1.5), std::min(current_before, 1.0)))
      return true;
  }
  vertices[v] = old;
  return false;
}

int CutPatch::Locate(const Vec3& p, const std::vector<int>& near_sources, Vec4* weights) const {
  int best = -1;
  double inside = -1e300;
  auto visit = [&](int t) {
    const auto& v = tets[t].v;
    const Vec4 w = BarycentricWeights(p, vertices[v[0]].rest, vertices[v[1]].rest,
                                      vertices[v[2]].rest, vertices[v[3]].rest);
    if (w.minCoeff() > inside) {
      inside = w.minCoeff();
      best = t;
      *weights = w;
    }
  };
  for (int t : near_sources) {
    visit(t);
    if (inside >= kInside) return best;
  }
  std::vector<std::uint64_t> more((tets.size() + 63) / 64, 0);  // a bit for each tetrahedron
  for (int t : near_sources)
    for (int v : tets[t].v)
      for (int w : star[v]) more[w / 64] |= std::uint64_t(1) << (w % 64);
  for (std::size_t word = 0; word < more.size(); ++word)
    for (std::uint64_t bits = more[word]; bits != 0; bits &= bits - 1) {
      visit(static_cast<int>(64 * word) + __builtin_ctzll(bits));
      if (inside >= kInside) return best;
    }
  return best;
}

Vec3 CutPatch::CurrentOf(int t, const Vec4& weights) const {
  Vec3 p = Vec3::Zero();
  for (int k = 0; k < 4; ++k) p += weights[k] * vertices[tets[t].v[k]].current;
  return p;
}

}  // namespace kerf
