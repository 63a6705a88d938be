#include "Registration/Silhouette.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "Core/Features.h"

namespace kerf {
namespace {

constexpr double kLongestMove_mm = 2.5;
constexpr double kBlind_mm = 6.0;     // around a place where the rest outline is not seen
constexpr double kBlindOff_px = 5.0;  // seen farther off than this at rest: not the organ's outline

constexpr double kOutside_px = 6.0;  // a step outwards from the outer outline leaves the model

/// Edges, what lies beside them, and a tetrahedron at each vertex, from the triangles.
void LinkTriangles(Index vertices, BoundaryTopology* out) {
  out->tet_of_vertex.assign(vertices, -1);
  // Sides by their smaller vertex, counted first: few share one and have to be sorted.
  struct Side {
    Index smaller, larger, triangle;
  };
  std::vector<Side> unsorted;
  unsorted.reserve(3 * out->triangles.rows());
  std::vector<std::size_t> place(vertices + 1, 0);
  for (Index t = 0; t < out->triangles.rows(); ++t)
    for (int k = 0; k < 3; ++k) {
      const Index a = out->triangles(t, k), b = out->triangles(t, (k + 1) % 3);
      unsorted.push_back({std::min(a, b), std::max(a, b), t});
      ++place[std::min(a, b) + 1];
      out->tet_of_vertex[a] = out->tet_of_triangle[t];
    }
  std::partial_sum(place.begin(), place.end(), place.begin());
  std::vector<Side> sides(unsorted.size());
  for (const Side& side : unsorted) sides[place[side.smaller]++] = side;
  std::size_t begin = 0;
  for (const std::size_t end : place) {  // each is where the next vertex' sides begin by now
    std::sort(sides.begin() + begin, sides.begin() + end, [](const Side& l, const Side& r) {
      return l.larger != r.larger ? l.larger < r.larger : l.triangle < r.triangle;
    });
    begin = end;
  }
  out->edges.reserve(sides.size() / 2);
  out->beside.reserve(sides.size() / 2);
  for (std::size_t i = 0; i + 1 < sides.size(); i += 2) {
    out->edges.push_back({sides[i].smaller, sides[i].larger});
    out->beside.push_back({sides[i].triangle, sides[i + 1].triangle});
  }
}

/// Whether one of these places (N×3, mm) is so near that the outline is not to be believed there.
bool IsBeside(const Points& blind, const Eigen::RowVector3d& rest) {
  for (Index i = 0; i < blind.rows(); ++i)
    if ((rest - blind.row(i)).squaredNorm() < kBlind_mm * kBlind_mm) return true;
  return false;
}

}  // namespace

BoundaryTopology MakeBoundaryTopology(const TetMesh& mesh, const Points& blind) {
  BoundaryTopology out;
  out.triangles = BoundaryFaces(mesh.tets, &out.tet_of_triangle);
  LinkTriangles(mesh.VertexCount(), &out);
  out.blind.assign(mesh.VertexCount(), 0);
  for (Index v = 0; v < mesh.VertexCount(); ++v)
    if (out.tet_of_vertex[v] >= 0) out.blind[v] = IsBeside(blind, mesh.rest.row(v));
  return out;
}

BoundaryTopology FollowCut(const BoundaryTopology& old, const TetMesh& before,
                           const TopologyChange& change, const Points& blind) {
  const TetMesh& mesh = change.mesh;
  if (static_cast<Index>(old.tet_of_vertex.size()) != before.VertexCount())
    return MakeBoundaryTopology(mesh, blind);
  // A face whose corners are not all at changed tetrahedra has the same tetrahedra on its sides.
  std::vector<char> touched(mesh.VertexCount(), 0);
  for (Index t = 0; t < before.TetCount(); ++t) {
    const Index kept = change.kept_tet[t];
    if (kept >= 0 && mesh.tets.row(kept) == before.tets.row(t)) continue;
    for (int k = 0; k < 4; ++k) {
      touched[before.tets(t, k)] = 1;
      if (kept >= 0) touched[mesh.tets(kept, k)] = 1;
    }
  }
  for (const Index t : change.new_tets)
    for (int k = 0; k < 4; ++k) touched[mesh.tets(t, k)] = 1;
  const auto all_touched = [&](const auto& corners) {
    return touched[corners[0]] && touched[corners[1]] && touched[corners[2]];
  };
  std::vector<Index> near;  // tetrahedra with a face that has to be looked at
  for (Index t = 0; t < mesh.TetCount(); ++t)
    if (touched[mesh.tets(t, 0)] + touched[mesh.tets(t, 1)] + touched[mesh.tets(t, 2)] +
            touched[mesh.tets(t, 3)] >=
        3)
      near.push_back(t);
  Tets tets(near.size(), 4);
  for (std::size_t i = 0; i < near.size(); ++i) tets.row(i) = mesh.tets.row(near[i]);
  std::vector<Index> tet_of_face;
  const Triangles faces = BoundaryFaces(tets, &tet_of_face);

  struct Face {
    Index tet, opposite;  ///< the order of BoundaryFaces: by tetrahedron, by the corner across
    std::array<Index, 3> corners;
    bool operator<(const Face& o) const {
      return tet != o.tet ? tet < o.tet : opposite < o.opposite;
    }
  };
  std::vector<Face> boundary;
  boundary.reserve(old.triangles.rows() + faces.rows());
  const auto add = [&](const auto& triangle, Index tet) {
    const std::array<Index, 3> corners{triangle[0], triangle[1], triangle[2]};
    Index opposite = 0;
    while (std::count(corners.begin(), corners.end(), mesh.tets(tet, opposite)) > 0) ++opposite;
    boundary.push_back({tet, opposite, corners});
  };
  for (Index i = 0; i < old.triangles.rows(); ++i)
    if (!all_touched(old.triangles.row(i)))
      add(old.triangles.row(i), change.kept_tet[old.tet_of_triangle[i]]);
  for (Index i = 0; i < faces.rows(); ++i)
    if (all_touched(faces.row(i))) add(faces.row(i), near[tet_of_face[i]]);
  std::sort(boundary.begin(), boundary.end());

  BoundaryTopology out;
  out.triangles.resize(boundary.size(), 3);
  out.tet_of_triangle.resize(boundary.size());
  for (std::size_t i = 0; i < boundary.size(); ++i) {
    for (int k = 0; k < 3; ++k) out.triangles(i, k) = boundary[i].corners[k];
    out.tet_of_triangle[i] = boundary[i].tet;
  }
  LinkTriangles(mesh.VertexCount(), &out);
  out.blind.assign(mesh.VertexCount(), 0);
  for (Index v = 0; v < mesh.VertexCount(); ++v) {
    if (out.tet_of_vertex[v] < 0) continue;
    const bool known = v < before.VertexCount() && old.tet_of_vertex[v] >= 0 && !touched[v];
    out.blind[v] = known ? old.blind[v] : IsBeside(blind, mesh.rest.row(v));
  }
  return out;
}

Points BlindOutline(const SilhouetteTargets& at_rest, const TetMesh& mesh,
                    const CameraModel& camera) {
  const Points model = at_rest.at.Positions(mesh.rest, mesh.tets);
  Points blind(model.rows(), 3);
  Index count = 0;
  for (Index i = 0; i < model.rows(); ++i) {
    const double off_px = (at_rest.targets.row(i) - model.row(i)).norm() * camera.fx /
                          camera.Depth(model.row(i).transpose());
    if (off_px > kBlindOff_px) blind.row(count++) = model.row(i);
  }
  blind.conservativeResize(count, 3);
  return blind;
}

SilhouetteTargets FindSilhouette(const BoundaryTopology& boundary, const TetMesh& mesh,
                                 const Points& positions, const CameraModel& camera,
                                 const Image& model_mask, const Image& organ_mask, int reach) {
  SilhouetteTargets out;
  out.at.weights.resize(0, 4);
  out.targets.resize(0, 3);
  for (const Image* mask : {&model_mask, &organ_mask})
    if (mask->width != camera.width || mask->height != camera.height) return out;
  const Vec3 eye = camera.Center();
  std::vector<char> front(boundary.triangles.rows());
  for (Index t = 0; t < boundary.triangles.rows(); ++t) {
    const Vec3 a = positions.row(boundary.triangles(t, 0)).transpose();
    const Vec3 b = positions.row(boundary.triangles(t, 1)).transpose();
    const Vec3 c = positions.row(boundary.triangles(t, 2)).transpose();
    front[t] = (b - a).cross(c - a).dot(eye - a) > 0.0;
  }
  const auto covered = [&](const Vec2& p) {
    const long u = std::lround(p.x()), v = std::lround(p.y());
    return u >= 0 && v >= 0 && u < model_mask.width && v < model_mask.height &&
           model_mask.data[std::size_t(v) * model_mask.width + u] != 0;
  };
  std::vector<char> used(positions.rows(), 0);
  std::vector<Index> vertices;
  std::vector<Vec3> targets;
  std::vector<double> confidence, off_px, length_px;
  std::vector<double> profile(2 * reach + 1);
  for (std::size_t e = 0; e < boundary.edges.size(); ++e) {
    if (front[boundary.beside[e][0]] == front[boundary.beside[e][1]]) continue;
    const auto [va, vb] = boundary.edges[e];
    if (used[va] || boundary.blind[va]) continue;
    const Vec3 world = positions.row(va).transpose();
    const Vec2 a = camera.Project(world), b = camera.Project(positions.row(vb).transpose());
    if (!a.allFinite() || !b.allFinite() || (b - a).norm() < 0.5) continue;
    if (!camera.InImage(a, reach + 2.0)) continue;
    Vec2 normal(-(b - a).y(), (b - a).x());
    normal.normalize();
    const Vec2 middle = 0.5 * (a + b);
    const bool plus = covered(middle + kOutside_px * normal);
    if (plus == covered(middle - kOutside_px * normal)) continue;  // an inner fold
    if (plus) normal = -normal;                                    // outwards
    used[va] = 1;
    // Best step: organ before it, background behind it.
    double behind = 0.0, before = 0.0;
    for (int s = -reach; s <= reach; ++s) {
      const Vec2 p = a + s * normal;
      const std::size_t pixel =
          std::size_t(std::lround(p.y())) * organ_mask.width + std::size_t(std::lround(p.x()));
      // What an instrument hides speaks for nothing: where the organ goes in under a clamp, it
      // does not end.
      const std::uint8_t seen = organ_mask.data[pixel];
      profile[s + reach] = seen == OrganSegmenter::kHidden ? 0.0 : seen ? 1.0 : -1.0;
      behind += profile[s + reach];
    }
    double best = -1e30;
    int best_step = 0;
    for (int s = -reach; s <= reach + 1; ++s) {
      if (before - behind > best) {
        best = before - behind;
        best_step = s;
      }
      if (s > reach) break;
      before += profile[s + reach];
      behind -= profile[s + reach];
    }
    if (best_step <= -reach + 2 || best_step >= reach - 1) continue;  // no step in reach
    double organ_side = 0.0, ground_side = 0.0;
    constexpr int kSide = 4;
    for (int s = 1; s <= kSide; ++s) {
      if (best_step - s + reach >= 0) organ_side += profile[best_step - s + reach];
      if (best_step - 1 + s + reach <= 2 * reach) ground_side -= profile[best_step - 1 + s + reach];
    }
    const double sure = std::min(organ_side, ground_side) / kSide;
    if (sure < 0.7) continue;
    const double step = best_step - 0.5;  // between the last organ and the first background pixel
    vertices.push_back(va);
    // A far outline draws steadily instead of being taken for an outlier.
    Vec3 move = camera.PointAtDepth(a + step * normal, camera.Depth(world)) - world;
    if (move.norm() > kLongestMove_mm) move *= kLongestMove_mm / move.norm();
    targets.push_back(world + move);
    confidence.push_back(sure);
    off_px.push_back(std::abs(step));
    length_px.push_back((b - a).norm());
  }
  const Index n = static_cast<Index>(vertices.size());
  out.at.tet.resize(n);
  out.at.weights = Weights4::Zero(n, 4);
  out.targets.resize(n, 3);
  out.confidence.resize(n);
  out.off_px.resize(n);
  out.length_px.resize(n);
  for (Index i = 0; i < n; ++i) {
    out.at.tet[i] = boundary.tet_of_vertex[vertices[i]];
    for (int c = 0; c < 4; ++c)
      if (mesh.tets(out.at.tet[i], c) == vertices[i]) out.at.weights(i, c) = 1.0;
    out.targets.row(i) = targets[i].transpose();
    out.confidence[i] = confidence[i];
    out.off_px[i] = off_px[i];
    out.length_px[i] = length_px[i];
  }
  return out;
}

}  // namespace kerf
