#include "Registration/CutView.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>

#include "Registration/CutLine.h"

namespace kerf {
namespace {

constexpr double kNear_mm = 2.5;    // an edge of a cut this near to its line is a lip of it
constexpr double kParted_mm = 6.0;  // neighbouring points farther apart than this are no line

/// Runs of neighbouring points.
std::vector<Points> Runs(const Points& line) {
  std::vector<Points> runs;
  Index first = 0;
  for (Index i = 1; i <= line.rows(); ++i) {
    if (i < line.rows() && (line.row(i) - line.row(i - 1)).norm() < kParted_mm) continue;
    if (i - first > 1) runs.push_back(line.middleRows(first, i - first));
    first = i;
  }
  return runs;
}

/// Edges between the outer surface and a face of a cut, in mesh vertices.
std::vector<std::array<Index, 2>> LipEdges(const Triangles& boundary,
                                           const std::vector<std::uint8_t>& is_cut) {
  std::map<std::array<Index, 2>, int> sides;  // bit 0: outer, bit 1: face of a cut
  for (Index t = 0; t < boundary.rows(); ++t)
    for (int k = 0; k < 3; ++k) {
      const Index a = boundary(t, k), b = boundary(t, (k + 1) % 3);
      sides[{std::min(a, b), std::max(a, b)}] |= is_cut[t] ? 2 : 1;
    }
  std::vector<std::array<Index, 2>> edges;
  for (const auto& [edge, seen] : sides)
    if (seen == 3) edges.push_back(edge);
  return edges;
}

/// Joins edges to lines, from end to end where there are ends.
std::vector<std::vector<Index>> Chains(const std::vector<std::array<Index, 2>>& edges) {
  std::map<Index, std::vector<std::size_t>> at;
  for (std::size_t e = 0; e < edges.size(); ++e)
    for (const Index v : edges[e]) at[v].push_back(e);
  std::vector<char> used(edges.size(), 0);
  std::vector<std::vector<Index>> chains;
  const auto walk = [&](Index v) {
    std::vector<Index> chain{v};
    while (true) {
      const auto& around = at[v];
      const auto next =
          std::find_if(around.begin(), around.end(), [&](std::size_t e) { return !used[e]; });
      if (next == around.end()) break;
      used[*next] = 1;
      v = edges[*next][0] == v ? edges[*next][1] : edges[*next][0];
      chain.push_back(v);
    }
    if (chain.size() > 1) chains.push_back(std::move(chain));
  };
  for (const auto& [v, around] : at)
    if (around.size() == 1) walk(v);
  for (const auto& [v, around] : at) walk(v);
  return chains;
}

/// Mesh vertices as an embedding.
Embedding AtVertices(const std::vector<Index>& vertices, const std::vector<Index>& tet_of_vertex,
                     const Tets& tets) {
  Embedding out;
  out.weights = Weights4::Zero(vertices.size(), 4);
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    out.tet.push_back(tet_of_vertex[vertices[i]]);
    for (int c = 0; c < 4; ++c)
      out.weights(i, c) = tets(out.tet.back(), c) == vertices[i] ? 1.0 : 0.0;
  }
  return out;
}

/// A line on the surface of an organ that is not cut there.
Embedding OnSurface(const Points& line, const SurfaceTree& surface, const Triangles& boundary,
                    const std::vector<Index>& tet_of_face, const Tets& tets) {
  Embedding out;
  out.weights = Weights4::Zero(line.rows(), 4);
  for (Index i = 0; i < line.rows(); ++i) {
    const SurfaceHit hit = surface.Closest(line.row(i).transpose());
    out.tet.push_back(tet_of_face[hit.triangle]);
    for (int k = 0; k < 3; ++k)
      for (int c = 0; c < 4; ++c)
        if (tets(out.tet.back(), c) == boundary(hit.triangle, k))
          out.weights(i, c) += hit.weights[k];
  }
  return out;
}

double DistanceTo(const Points& line, const Vec3& p) {
  double nearest = std::numeric_limits<double>::infinity();
  for (Index i = 0; i < line.rows(); ++i)
    nearest = std::min(nearest, (line.row(i).transpose() - p).norm());
  return nearest;
}

double SmallestDistance(const SurfaceMesh& a, const SurfaceMesh& b) {
  double smallest = std::numeric_limits<double>::infinity();
  const auto one_way = [&](const SurfaceMesh& from, const SurfaceTree& to) {
    std::vector<char> seen(from.points.rows(), 0);
    for (Index t = 0; t < from.triangles.rows(); ++t)
      for (int k = 0; k < 3; ++k) {
        const Index v = from.triangles(t, k);
        if (seen[v]++ == 0)
          smallest = std::min(smallest, to.Closest(from.points.row(v).transpose()).distance_mm);
      }
  };
  one_way(a, SurfaceTree(b));
  one_way(b, SurfaceTree(a));
  return smallest;
}

}  // namespace

void CutView::Rebind(const RegistrationState& state) {
  bound_.clear();
  lip_cuts_.clear();
  std::vector<Index> tet_of_face;
  const Triangles all = BoundaryFaces(state.mesh.tets, &tet_of_face);
  const SurfaceMesh rest = BoundarySurface(state.mesh, state.mesh.rest);
  const std::vector<std::uint8_t> is_cut = CutFaceFlags(rest, *state.uncut);
  faces_.resize(std::count(is_cut.begin(), is_cut.end(), 1), 3);
  std::vector<Index> tet_of_vertex(state.mesh.VertexCount(), 0);
  Index faces = 0;
  for (Index t = 0; t < all.rows(); ++t) {
    if (is_cut[t]) faces_.row(faces++) = all.row(t);
    for (int k = 0; k < 3; ++k) tet_of_vertex[all(t, k)] = tet_of_face[t];
  }
  const auto edges = LipEdges(all, is_cut);
  const SurfaceTree surface(rest);
  for (std::size_t c = 0; c < state.cuts.size(); ++c) {
    const ModelCut& cut = state.cuts[c];
    const Points line = LineOnSurface(cut.line, cut.view, *state.uncut);
    std::vector<std::array<Index, 2>> lips;
    for (const auto& edge : edges) {
      const Vec3 middle =
          0.5 * (state.mesh.rest.row(edge[0]) + state.mesh.rest.row(edge[1])).transpose();
      if (DistanceTo(line, middle) < kNear_mm) lips.push_back(edge);
    }
    for (const auto& chain : Chains(lips))
      bound_.push_back(AtVertices(chain, tet_of_vertex, state.mesh.tets));
    if (lips.empty())  // only proposed, or refused by the cutter
      for (const Points& run : Runs(line))
        bound_.push_back(OnSurface(run, surface, all, tet_of_face, state.mesh.tets));
    lip_cuts_.resize(bound_.size(), static_cast<int>(c));
  }
}

void CutView::Update(const RegistrationState& state) {
  lips_.clear();
  margin_mm_ = std::numeric_limits<double>::quiet_NaN();
  if (state.cuts.empty() || !state.uncut) return;
  Index line_points = 0;
  for (const ModelCut& cut : state.cuts) line_points += cut.line.points.rows();
  if (tets_ != state.mesh.TetCount() || vertices_ != state.mesh.VertexCount() ||
      line_points_ != line_points) {
    tets_ = state.mesh.TetCount();
    vertices_ = state.mesh.VertexCount();
    line_points_ = line_points;
    Rebind(state);
  }
  for (const Embedding& lip : bound_)
    lips_.push_back(lip.Positions(state.positions, state.mesh.tets));
  if (faces_.rows() == 0) return;
  const SurfaceMesh cut_faces{state.positions, faces_};
  for (const Structure& structure : state.structures) {
    if (structure.name != "tumour" || structure.rest.Empty()) continue;
    margin_mm_ = SmallestDistance(
        {structure.embedding.Positions(state.positions, state.mesh.tets), structure.rest.triangles},
        cut_faces);
  }
}

}  // namespace kerf
