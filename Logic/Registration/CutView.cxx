#include "Registration/CutView.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <optional>

#include "Registration/CutLine.h"

namespace kerf {
namespace {

constexpr double kNear_mm = 2.5;    // an edge of a cut this near to its line is a lip of it
constexpr Index kEnd_mm = 3;        // of the line, whose points lie 1 mm apart, are its end
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

/// An edge between the outer surface and a face of a cut.
struct LipEdge {
  std::array<Index, 2> ends;   ///< mesh vertices
  Index tet = -1;              ///< that has both
  Vec3 normal = Vec3::Zero();  ///< of the outer surface there, at rest, any length
};

std::vector<LipEdge> LipEdges(const Triangles& boundary, const std::vector<std::uint8_t>& is_cut,
                              const std::vector<Index>& tet_of_face, const Points& rest) {
  struct Seen {
    int sides = 0;  ///< bit 0: outer, bit 1: face of a cut
    Index tet = -1, outer = -1;
  };
  std::map<std::array<Index, 2>, Seen> seen;
  for (Index t = 0; t < boundary.rows(); ++t)
    for (int k = 0; k < 3; ++k) {
      const Index a = boundary(t, k), b = boundary(t, (k + 1) % 3);
      Seen& edge = seen[{std::min(a, b), std::max(a, b)}];
      edge.sides |= is_cut[t] ? 2 : 1;
      edge.tet = tet_of_face[t];
      if (!is_cut[t]) edge.outer = t;
    }
  std::vector<LipEdge> edges;
  for (const auto& [ends, edge] : seen) {
    if (edge.sides != 3) continue;
    const auto at = [&](int k) -> Vec3 { return rest.row(boundary(edge.outer, k)).transpose(); };
    edges.push_back({ends, edge.tet, (at(1) - at(0)).cross(at(2) - at(0))});
  }
  return edges;
}

/// A place on an edge of a lip.
struct LipPoint {
  const LipEdge* edge = nullptr;
  double along = 0.0;  ///< 0 … 1
};

/// The lips of one cut as edges between numbered points.
struct LipGraph {
  std::vector<LipPoint> points;
  std::vector<std::array<Index, 2>> edges;  ///< in `points`
};

/// A cut's line on the organ, in steps of 1 mm.
struct SurfaceLine {
  Points points;
  /// How far the lips go beyond its first and last point: to the rim where it leaves the organ.
  std::array<double, 2> beyond_mm{0.0, 0.0};
};

SurfaceLine LineOf(const ModelCut& cut, const SurfaceTree& uncut) {
  SurfaceLine line{LineOnSurface(cut.line, cut.view, uncut)};
  if (line.points.rows() == 0) return line;
  for (const int end : {0, 1}) {
    const Vec3 given = cut.line.points.row(end ? cut.line.points.rows() - 1 : 0).transpose();
    const Vec3 on_organ = line.points.row(end ? line.points.rows() - 1 : 0).transpose();
    const bool leaves = (given - on_organ).cross(cut.view).norm() > 1e-3;
    if (leaves) line.beyond_mm[end] = 1.0;
  }
  return line;
}

/// Number of the line's point that is nearest to `p`.
Index NearestOf(const Points& line, const Vec3& p) {
  Index nearest = 0;
  (line.rowwise() - p.transpose()).rowwise().squaredNorm().minCoeff(&nearest);
  return nearest;
}

/// The part of an edge that lies between the two ends of the line: the mesh opens as far as its
/// elements reach, the line says where the cut ends.
/// @return first and last place on the edge, 0 … 1; none where all of it lies beyond
std::optional<std::array<double, 2>> Within(const SurfaceLine& given, const Vec3& a,
                                            const Vec3& b) {
  const Points& line = given.points;
  double from = 0.0, to = 1.0;
  const Index last = line.rows() - 1, nearest = NearestOf(line, 0.5 * (a + b));
  for (const bool start : {true, false}) {
    if ((start ? nearest : last - nearest) > kEnd_mm) continue;
    const Vec3 end = line.row(start ? 0 : last).transpose();
    const Index back = std::min(kEnd_mm, last);
    const Vec3 outwards = (end - line.row(start ? back : last - back).transpose()).normalized();
    const double beyond_mm = given.beyond_mm[start ? 0 : 1];
    const double at_a = outwards.dot(a - end) - beyond_mm, at_b = outwards.dot(b - end) - beyond_mm;
    if (at_a > 0 && at_b > 0) return std::nullopt;
    if (at_a > 0) from = std::max(from, at_a / (at_a - at_b));
    if (at_b > 0) to = std::min(to, at_a / (at_a - at_b));
  }
  if (from >= to) return std::nullopt;
  return std::array<double, 2>{from, to};
}

/// @param view direction in which the cut was seen: lips lie on the side that faces it
LipGraph LipsNear(const SurfaceLine& line, const std::vector<LipEdge>& edges, const Vec3& view,
                  const Points& rest) {
  LipGraph lips;
  if (line.points.rows() < 2) return lips;
  std::map<Index, Index> number;  // of whole vertices, which edges share
  for (const LipEdge& edge : edges) {
    if (edge.normal.dot(view) > 0.0) continue;
    const Vec3 a = rest.row(edge.ends[0]).transpose(), b = rest.row(edge.ends[1]).transpose();
    const auto part = Within(line, a, b);
    if (!part) continue;
    const Vec3 middle = a + 0.5 * ((*part)[0] + (*part)[1]) * (b - a);
    const Index nearest = NearestOf(line.points, middle);
    if ((line.points.row(nearest).transpose() - middle).norm() > kNear_mm) continue;
    std::array<Index, 2> ends;
    for (int k = 0; k < 2; ++k) {
      const double along = (*part)[k];
      const bool whole = along == k;
      const auto [known, fresh] =
          whole ? number.insert({edge.ends[k], lips.points.size()})
                : std::pair<std::map<Index, Index>::iterator, bool>{number.end(), true};
      ends[k] = fresh ? static_cast<Index>(lips.points.size()) : known->second;
      if (fresh) lips.points.push_back({&edge, along});
    }
    lips.edges.push_back(ends);
  }
  return lips;
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

Embedding Bind(const std::vector<Index>& chain, const std::vector<LipPoint>& points,
               const Tets& tets) {
  Embedding out;
  out.weights = Weights4::Zero(chain.size(), 4);
  for (std::size_t i = 0; i < chain.size(); ++i) {
    const LipPoint& point = points[chain[i]];
    out.tet.push_back(point.edge->tet);
    for (int c = 0; c < 4; ++c) {
      if (tets(point.edge->tet, c) == point.edge->ends[0]) out.weights(i, c) = 1.0 - point.along;
      if (tets(point.edge->tet, c) == point.edge->ends[1]) out.weights(i, c) = point.along;
    }
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

/// A point cannot be nearer than a neighbour's distance less the way to it, so most need no query.
double SmallestDistance(const SurfaceMesh& a, const SurfaceMesh& b) {
  double smallest = std::numeric_limits<double>::infinity();
  const auto one_way = [&](const SurfaceMesh& from, const SurfaceTree& to) {
    std::vector<char> seen(from.points.rows(), 0);
    Vec3 asked = Vec3::Zero();
    double distance = -1.0;
    for (Index t = 0; t < from.triangles.rows(); ++t)
      for (int k = 0; k < 3; ++k) {
        const Index v = from.triangles(t, k);
        if (seen[v]++ > 0) continue;
        const Vec3 p = from.points.row(v).transpose();
        if (distance - (p - asked).norm() > smallest) continue;
        asked = p;
        distance = to.Closest(p).distance_mm;
        smallest = std::min(smallest, distance);
      }
  };
  one_way(a, SurfaceTree(b));
  one_way(b, SurfaceTree(a));
  return smallest;
}

}  // namespace

void CutView::Rebind(const RegistrationState& state, const std::vector<std::uint8_t>* cut_face) {
  bound_.clear();
  lip_cuts_.clear();
  std::vector<Index> tet_of_face;
  const Triangles all = BoundaryFaces(state.mesh.tets, &tet_of_face);
  const SurfaceMesh rest{state.mesh.rest, all};
  // The caller's flags may be those of another model.
  const bool given = cut_face && Index(cut_face->size()) == all.rows();
  const std::vector<std::uint8_t> is_cut = given ? *cut_face : CutFaceFlags(rest, *state.uncut);
  faces_.resize(std::count(is_cut.begin(), is_cut.end(), 1), 3);
  Index faces = 0;
  for (Index t = 0; t < all.rows(); ++t)
    if (is_cut[t]) faces_.row(faces++) = all.row(t);
  const std::vector<LipEdge> edges = LipEdges(all, is_cut, tet_of_face, state.mesh.rest);
  std::optional<SurfaceTree> surface;
  for (std::size_t c = 0; c < state.cuts.size(); ++c) {
    const ModelCut& cut = state.cuts[c];
    const SurfaceLine line = LineOf(cut, *state.uncut);
    const LipGraph lips = LipsNear(line, edges, cut.view, state.mesh.rest);
    for (const auto& chain : Chains(lips.edges))
      bound_.push_back(Bind(chain, lips.points, state.mesh.tets));
    if (lips.edges.empty()) {  // only proposed, or refused by the cutter
      if (!surface) surface.emplace(rest);
      for (const Points& run : Runs(line.points))
        bound_.push_back(OnSurface(run, *surface, all, tet_of_face, state.mesh.tets));
    }
    lip_cuts_.resize(bound_.size(), static_cast<int>(c));
  }
}

bool CutView::LinesChanged(const RegistrationState& state) {
  bool changed = lines_.size() != state.cuts.size();
  lines_.resize(state.cuts.size());
  for (std::size_t c = 0; c < lines_.size(); ++c) {
    auto& [points, view] = lines_[c];
    const ModelCut& cut = state.cuts[c];
    if (points.rows() == cut.line.points.rows() && points == cut.line.points && view == cut.view)
      continue;
    points = cut.line.points;
    view = cut.view;
    changed = true;
  }
  return changed;
}

void CutView::Update(const RegistrationState& state, const std::vector<std::uint8_t>* cut_face) {
  lips_.clear();
  margin_mm_ = std::numeric_limits<double>::quiet_NaN();
  if (state.cuts.empty() || !state.uncut) return;
  const bool another_mesh = watch_.Changed(state.mesh), other_lines = LinesChanged(state);
  if (another_mesh || other_lines) Rebind(state, cut_face);
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
