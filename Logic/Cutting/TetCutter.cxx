#include "Cutting/TetCutter.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>
#include <optional>

#include "Cutting/CutPatch.h"
#include "Cutting/CutRemeshing.h"
#include "Cutting/Separation.h"
#include "Cutting/SurfaceIndex.h"

namespace kerf {
namespace {

constexpr double kDeformedAngle_deg = 0.6;
constexpr double kContextEdges =
    5;  // mean edges around what is new in S in which the old S still counts
constexpr double kSlack = 1e-4;  // mean edges: a face this near to S may count as on it
constexpr int kRings = 2;  // around the tetrahedra that S crosses: room for snapping and smoothing

double AngleOf(double cosine) {
  return cosine > 1 ? 0 : std::acos(std::clamp(cosine, -1.0, 1.0)) * 180 / M_PI;
}

struct Chosen {
  std::vector<Index> tets;  // ascending
  std::vector<char> inner;  // vertices whose tetrahedra are all chosen
};

std::uint64_t HashOf(const CutSurface& surface, Index triangle) {
  std::uint64_t hash = 1469598103934665603u;
  for (int k = 0; k < 3; ++k)
    for (int axis = 0; axis < 3; ++axis) {
      const double x = surface.points(surface.triangles(triangle, k), axis);
      std::uint64_t bits;
      std::memcpy(&bits, &x, sizeof(bits));
      hash = (hash ^ bits) * 0x9E3779B97F4A7C15u;
      hash ^= hash >> 29;
    }
  return hash;
}

struct Box {
  Eigen::RowVector3d low = Eigen::RowVector3d::Constant(1e300);
  Eigen::RowVector3d high = Eigen::RowVector3d::Constant(-1e300);
  template <class Row>
  void Add(const Row& p) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  void Grow(double margin) {
    low.array() -= margin;
    high.array() += margin;
  }
  bool Meets(const Box& o) const {
    return (low.array() <= o.high.array()).all() && (o.low.array() <= high.array()).all();
  }
};

Box BoxOf(const Points& points,
          const Eigen::Ref<const Eigen::Matrix<Index, 1, Eigen::Dynamic>>& row) {
  Box box;
  for (Index k = 0; k < row.size(); ++k) box.Add(points.row(row[k]));
  return box;
}

/// The triangles that `take` chooses, with their points.
template <class Take>
CutSurface Part(const CutSurface& surface, Take take) {
  CutSurface part;
  std::vector<Index> number(surface.points.rows(), -1);
  std::vector<Index> used;
  part.triangles.resize(surface.triangles.rows(), 3);
  Index n = 0;
  for (Index t = 0; t < surface.triangles.rows(); ++t) {
    if (!take(t)) continue;
    for (int k = 0; k < 3; ++k) {
      const Index v = surface.triangles(t, k);
      if (number[v] < 0) {
        number[v] = static_cast<Index>(used.size());
        used.push_back(v);
      }
      part.triangles(n, k) = number[v];
    }
    ++n;
  }
  part.triangles.conservativeResize(n, 3);
  part.points.resize(used.size(), 3);
  for (std::size_t i = 0; i < used.size(); ++i) part.points.row(i) = surface.points.row(used[i]);
  return part;
}

double MeanEdge_mm(const TetMesh& mesh) {
  double sum = 0;
  Index n = 0;
  const Index stride = std::max<Index>(1, mesh.TetCount() / 500);
  for (Index t = 0; t < mesh.TetCount(); t += stride, ++n)
    sum += (mesh.rest.row(mesh.tets(t, 0)) - mesh.rest.row(mesh.tets(t, 1))).norm();
  return n > 0 ? sum / n : 0;
}

/// Tetrahedra in `region` whose box S comes into, or passes within the slack: those on both sides
/// of a face that lies on S but for rounding.
std::vector<Index> TetsNear(const TetMesh& mesh, const Box& region, const SurfaceIndex& index,
                            double slack_mm) {
  std::vector<char> beyond(mesh.VertexCount());  // bits: which of the region's six planes
  for (Index v = 0; v < mesh.VertexCount(); ++v)
    for (int k = 0; k < 3; ++k)
      beyond[v] |= (mesh.rest(v, k) < region.low[k]) << k | (mesh.rest(v, k) > region.high[k])
                                                                << (k + 3);
  std::vector<Index> near;
  for (Index t = 0; t < mesh.TetCount(); ++t) {
    if (beyond[mesh.tets(t, 0)] & beyond[mesh.tets(t, 1)] & beyond[mesh.tets(t, 2)] &
        beyond[mesh.tets(t, 3)])
      continue;
    Box tet = BoxOf(mesh.rest, mesh.tets.row(t));
    tet.Grow(slack_mm);
    if (index.MeetsBox(tet.low.transpose(), tet.high.transpose())) near.push_back(t);
  }
  return near;
}

/// `core` tetrahedra and `rings` rings around them.
Chosen WithRings(const TetMesh& mesh, const std::vector<Index>& core, int rings) {
  Chosen chosen;
  chosen.tets = core;
  for (int ring = 0; ring < rings; ++ring) {
    chosen.inner.assign(mesh.VertexCount(), 0);
    for (Index t : chosen.tets)
      for (int k = 0; k < 4; ++k) chosen.inner[mesh.tets(t, k)] = 1;
    chosen.tets.clear();
    for (Index t = 0; t < mesh.TetCount(); ++t)
      if (chosen.inner[mesh.tets(t, 0)] | chosen.inner[mesh.tets(t, 1)] |
          chosen.inner[mesh.tets(t, 2)] | chosen.inner[mesh.tets(t, 3)])
        chosen.tets.push_back(t);
  }
  return chosen;
}

struct Attempt {
  CutPatch patch;
  SeparationReport separation;
  Index snapped = 0;
  double angle_deg = 0;           ///< smallest at rest among changed tetrahedra
  double angle_current_deg = 90;  ///< as deformed
  bool given_up = false;          ///< no end to the edges that S crosses
};

Attempt Try(const CutPatch& before, const SurfaceIndex& surface, const RemeshingOptions& options,
            bool snapping) {
  Attempt attempt{before, {}, 0, 180, 180, false};
  RemeshingOptions used = options;
  if (!snapping) used.snap_fraction = used.accept_fraction = 0;
  attempt.snapped = SnapVertices(surface, used, before, &attempt.patch);
  if (!SplitCrossedEdges(surface, &attempt.patch)) {
    attempt.given_up = true;
    return attempt;
  }
  if (snapping) ImprovePatch(surface, used, before, &attempt.patch);
  attempt.separation = OpenFacesOnS(surface, &attempt.patch);
  const CutPatch& patch = attempt.patch;
  double worst = -1, worst_current = -1;
  for (std::size_t t = 0; t < patch.tets.size(); ++t) {
    if (!patch.tets[t].changed) continue;
    worst = std::max(worst, patch.WorstCosine(static_cast<int>(t)));
    if (patch.deformed)
      worst_current = std::max(worst_current, patch.WorstCosineCurrent(static_cast<int>(t)));
  }
  attempt.angle_deg = AngleOf(worst);
  attempt.angle_current_deg = AngleOf(worst_current);
  return attempt;
}

/// Nothing changed, in memory for a mesh of this size.
TopologyChange Unchanged(const TetMesh& mesh, Index vertices, Index tets) {
  TopologyChange change;
  change.mesh.rest.resize(vertices, 3);
  change.mesh.rest.topRows(mesh.VertexCount()) = mesh.rest;
  change.mesh.tets.resize(tets, 4);
  change.mesh.tets.topRows(mesh.TetCount()) = mesh.tets;
  change.mesh.region.reserve(tets);
  change.mesh.region = mesh.region;
  change.mesh.region.resize(tets);
  change.vertex_parents.resize(vertices);
  change.vertex_weights.resize(vertices, 4);
  for (Index v = 0; v < mesh.VertexCount(); ++v) {
    change.vertex_parents[v].fill(v);
    change.vertex_weights.row(v) << 1, 0, 0, 0;
  }
  change.parent_tet.resize(tets);
  std::iota(change.parent_tet.begin(), change.parent_tet.begin() + mesh.TetCount(), 0);
  change.kept_tet.assign(change.parent_tet.begin(), change.parent_tet.begin() + mesh.TetCount());
  return change;
}

/// Puts the patch back into the mesh. Unchanged tetrahedra and all old vertices keep their numbers.
TopologyChange Assemble(const TetMesh& mesh, const CutPatch& before, const Attempt& attempt) {
  const CutPatch& patch = attempt.patch;
  std::vector<Index> number(patch.vertices.size());
  Index vertex_count = mesh.VertexCount();
  for (std::size_t v = 0; v < patch.vertices.size(); ++v)
    number[v] = patch.vertices[v].old_vertex >= 0 ? patch.vertices[v].old_vertex : vertex_count++;
  std::vector<Index> places;  // of changed old tetrahedra
  for (std::size_t t = 0; t < before.tets.size(); ++t)
    if (patch.tets[t].changed) places.push_back(before.old_tet[t]);
  const Index fresh = static_cast<Index>(
      std::count_if(patch.tets.begin(), patch.tets.end(), [](const auto& t) { return t.changed; }));
  Index tet_count = mesh.TetCount();
  TopologyChange change =
      Unchanged(mesh, vertex_count, tet_count + fresh - static_cast<Index>(places.size()));
  change.changed = true;
  for (Index t : places) change.kept_tet[t] = -1;
  for (std::size_t v = 0; v < patch.vertices.size(); ++v) {
    const auto& vertex = patch.vertices[v];
    if (vertex.old_vertex >= 0 && !vertex.moved) continue;
    std::vector<int> sources;
    for (int t : patch.star[v]) sources.push_back(patch.tets[t].source);
    std::sort(sources.begin(), sources.end());
    sources.erase(std::unique(sources.begin(), sources.end()), sources.end());
    Vec4 weights;
    const auto& holder = before.tets[before.Locate(vertex.rest, sources, &weights)].v;
    change.mesh.rest.row(number[v]) = vertex.rest.transpose();
    for (int k = 0; k < 4; ++k)
      if ((weights - Vec4::Unit(k)).cwiseAbs().maxCoeff() < 1e-12)
        weights = Vec4::Unit(k);  // a copy of an old vertex
    change.vertex_weights.row(number[v]) = weights.transpose();
    for (int k = 0; k < 4; ++k)
      change.vertex_parents[number[v]][k] = before.vertices[holder[k]].old_vertex;
  }
  std::size_t next_place = 0;
  std::vector<Index> tet_number(patch.tets.size());
  for (std::size_t t = 0; t < patch.tets.size(); ++t) {
    const auto& tet = patch.tets[t];
    if (!tet.changed) {
      tet_number[t] = before.old_tet[t];
      continue;
    }
    const Index at = next_place < places.size() ? places[next_place++] : tet_count++;
    Vec3 center = Vec3::Zero();
    for (int k = 0; k < 4; ++k) {
      change.mesh.tets(at, k) = number[tet.v[k]];
      center += patch.vertices[tet.v[k]].rest / 4;
    }
    Vec4 weights;
    change.parent_tet[at] = before.old_tet[before.Locate(center, {tet.source}, &weights)];
    change.mesh.region[at] = tet.region;
    change.new_tets.push_back(at);
    tet_number[t] = at;
  }
  std::sort(change.new_tets.begin(), change.new_tets.end());
  for (OpenedFace face : attempt.separation.faces) {
    for (int k = 0; k < 3; ++k) {
      face.a[k] = number[face.a[k]];
      face.b[k] = number[face.b[k]];
    }
    face.tet_a = tet_number[face.tet_a];
    face.tet_b = tet_number[face.tet_b];
    change.opened.push_back(face);
  }
  return change;
}

/// Pieces share no vertices: the boundary is 2-manifold.
std::vector<double> ComponentVolumes_mm3(const TetMesh& mesh) {
  std::vector<Index> root(mesh.VertexCount());
  std::iota(root.begin(), root.end(), 0);
  auto find = [&](Index i) {
    while (root[i] != i) i = root[i] = root[root[i]];
    return i;
  };
  for (Index t = 0; t < mesh.TetCount(); ++t) {
    Index a = find(mesh.tets(t, 0));
    for (int k = 1; k < 4; ++k) {
      const Index b = find(mesh.tets(t, k));
      if (a == b) continue;
      root[std::max(a, b)] = std::min(a, b);
      a = std::min(a, b);
    }
  }
  std::vector<int> component(mesh.VertexCount(), -1);
  std::vector<double> volumes;
  for (Index t = 0; t < mesh.TetCount(); ++t) {
    int& c = component[find(mesh.tets(t, 0))];
    if (c < 0) {
      c = static_cast<int>(volumes.size());
      volumes.push_back(0);
    }
    volumes[c] += TetVolume(mesh.rest, mesh.tets, t);
  }
  return volumes;
}

}  // namespace

TetCutter::TetCutter(CutOptions options) : options_(options) {}

TopologyChange TetCutter::Cut(const TetMesh& mesh, const CutSurface& surface, CutReport* report,
                              const Points* positions) {
  CutReport unused;
  CutReport& out = report ? *report : unused;
  out = {};
  const bool known = Knows(mesh);
  auto report_components = [&](const TetMesh& of, bool same_pieces) {
    if (known && same_pieces)
      out.component_volume_mm3 = memory_.component_volume_mm3;
    else
      out.component_volume_mm3 = ComponentVolumes_mm3(of);
    out.components = static_cast<int>(out.component_volume_mm3.size());
  };
  auto remember = [&](const TetMesh& result, std::vector<std::uint64_t> triangles) {
    memory_ = {std::move(triangles), result.VertexCount(), result.TetCount(),
               out.component_volume_mm3};
  };
  auto refuse = [&](const char* reason) {
    out.reason = reason;
    report_components(mesh, true);
    return Unchanged(mesh, mesh.VertexCount(), mesh.TetCount());
  };

  // Where S is new, and the part of S around it.
  std::vector<std::uint64_t> hashes(surface.triangles.rows());
  for (Index t = 0; t < surface.triangles.rows(); ++t) hashes[t] = HashOf(surface, t);
  const CutSurface fresh = Part(surface, [&](Index t) {
    return !known ||
           !std::binary_search(memory_.triangles.begin(), memory_.triangles.end(), hashes[t]);
  });
  std::sort(hashes.begin(), hashes.end());
  if (fresh.triangles.rows() == 0)
    return refuse(surface.triangles.rows() == 0 ? "the separation surface is empty"
                                                : "the separation surface separates nothing new");
  const double edge_mm = MeanEdge_mm(mesh);
  Box region;
  for (Index i = 0; i < fresh.points.rows(); ++i) region.Add(fresh.points.row(i));
  Box context = region;
  region.Grow(known ? edge_mm : kSlack * edge_mm);
  context.Grow(kContextEdges * edge_mm);
  const SurfaceIndex index(Part(surface, [&](Index t) {
    return context.Meets(BoxOf(surface.points, surface.triangles.row(t)));
  }));
  const std::vector<Index> near = TetsNear(mesh, region, index, kSlack * edge_mm);
  std::vector<Index> work;
  if (!near.empty()) {
    const std::vector<char> all_inner(mesh.VertexCount(), 1);
    work = TetsToWorkOn(index, CutPatch(mesh, nullptr, near, all_inner));
  }
  if (work.empty()) {
    TopologyChange unchanged =
        refuse(near.empty() ? "the separation surface does not meet the organ"
                            : "the separation surface separates nothing new");
    remember(mesh, std::move(hashes));
    return unchanged;
  }
  const Chosen chosen = WithRings(mesh, work, kRings);
  CutPatch before(mesh, positions, chosen.tets, chosen.inner);
  before.MarkCore(work);

  double worst = -1, worst_current = -1;
  for (std::size_t t = 0; t < before.tets.size(); ++t) {
    worst = std::max(worst, before.WorstCosine(static_cast<int>(t)));
    if (before.deformed)
      worst_current = std::max(worst_current, before.WorstCosineCurrent(static_cast<int>(t)));
  }
  const double before_deg = AngleOf(worst), before_current_deg = AngleOf(worst_current);
  const double required_deg = std::min(options_.min_dihedral_deg, before_deg);
  const double required_current_deg = std::min(kDeformedAngle_deg, 0.5 * before_current_deg);

  std::optional<Attempt> best;
  bool separates = false;
  int idle = 0;
  for (double factor : {1.0, 0.7, 1.25, 0.45}) {
    RemeshingOptions remeshing;
    remeshing.snap_fraction = factor * options_.snap_fraction;
    Attempt attempt = Try(before, index, remeshing, options_.snapping);
    if (attempt.given_up) {
      separates = true;
      continue;
    }
    if (attempt.separation.faces.empty()) {
      if (++idle == 2 && !separates) break;  // S only touches the organ
      continue;
    }
    separates = true;
    if (attempt.angle_current_deg < required_current_deg && before.deformed) continue;
    if (!best || attempt.angle_deg > best->angle_deg) best = std::move(attempt);
    if (best->angle_deg >= std::min(6.0, 2 * options_.min_dihedral_deg) || !options_.snapping)
      break;
  }
  if (!separates) return refuse("the separation surface separates nothing new");
  if (!best || (options_.snapping && best->angle_deg < required_deg))
    return refuse("no remeshing keeps the elements well shaped");

  TopologyChange change = Assemble(mesh, before, *best);
  out.done = true;
  out.new_vertices = change.mesh.VertexCount() - mesh.VertexCount();
  out.new_tets = change.mesh.TetCount() - mesh.TetCount();
  out.snapped_vertices = best->snapped;
  out.duplicated_vertices = best->separation.duplicated_vertices;
  out.cut_area_mm2 = best->separation.area_mm2;
  out.smallest_dihedral_deg = best->angle_deg;
  report_components(change.mesh, best->separation.same_pieces);
  remember(change.mesh, std::move(hashes));
  return change;
}

}  // namespace kerf
