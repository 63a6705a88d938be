#include "Registration/CutView.h"

#include <algorithm>

#include "Registration/CutLine.h"

namespace kerf {
namespace {

constexpr double kAside_mm = 0.3;   // a lip is bound this far beside the line: on its own side of S
constexpr double kParted_mm = 6.0;  // neighbouring points farther apart than this are no line

/// Binds a line to the tetrahedra that the points `aside` of it lie upon: it goes with their side.
Embedding BindAside(const Points& line, const Points& aside, const SurfaceTree& tree,
                    const std::vector<Index>& tet_of_triangle, const TetMesh& mesh) {
  Embedding out;
  out.tet.resize(line.rows());
  out.weights.resize(line.rows(), 4);
  const auto corner = [&](Index tet, int c) -> Vec3 {
    return mesh.rest.row(mesh.tets(tet, c)).transpose();
  };
  for (Index i = 0; i < line.rows(); ++i) {
    const Index t = tet_of_triangle[tree.Closest(aside.row(i).transpose()).triangle];
    out.tet[i] = t;
    out.weights.row(i) = BarycentricWeights(line.row(i).transpose(), corner(t, 0), corner(t, 1),
                                            corner(t, 2), corner(t, 3))
                             .transpose();
  }
  return out;
}

/// The points of a lip: `line` moved to one side within the plane across `direction`.
Points Aside(const Points& line, const Vec3& direction, double by_mm) {
  Points out = line;
  for (Index i = 0; i < line.rows(); ++i) {
    const Vec3 along =
        (line.row(std::min<Index>(i + 1, line.rows() - 1)) - line.row(std::max<Index>(i - 1, 0)))
            .transpose();
    out.row(i) += by_mm * along.cross(direction).normalized().transpose();
  }
  return out;
}

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
  std::vector<Index> tet_of_face, vertex_of_point;
  const Triangles all = BoundaryFaces(state.mesh.tets, &tet_of_face);
  const SurfaceMesh rest = BoundarySurface(state.mesh, state.mesh.rest, &vertex_of_point);
  const std::vector<std::uint8_t> is_cut = CutFaceFlags(rest, *state.uncut);
  const Index cut_count = static_cast<Index>(std::count(is_cut.begin(), is_cut.end(), 1));
  faces_.resize(cut_count, 3);
  // The outer surface alone: its lips meet at S, and each side has triangles of its own.
  Triangles outer(all.rows() - cut_count, 3);
  std::vector<Index> tet_of_outer;
  Index to_cut = 0, to_outer = 0;
  for (Index t = 0; t < all.rows(); ++t) {
    if (is_cut[t]) {
      faces_.row(to_cut++) = all.row(t);
    } else {
      outer.row(to_outer++) = rest.triangles.row(t);
      tet_of_outer.push_back(tet_of_face[t]);
    }
  }
  if (outer.rows() == 0) return;
  const SurfaceTree tree(SurfaceMesh{rest.points, outer});
  for (std::size_t c = 0; c < state.cuts.size(); ++c) {
    const ModelCut& cut = state.cuts[c];
    for (const Points& run : Runs(LineOnSurface(cut.line, cut.direction, *state.uncut)))
      for (const double side : {-kAside_mm, kAside_mm}) {
        lip_cuts_.push_back(static_cast<int>(c));
        bound_.push_back(
            BindAside(run, Aside(run, cut.direction, side), tree, tet_of_outer, state.mesh));
      }
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
