#include "Cutting/TetCutter.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "Cutting/CutPatch.h"
#include "Cutting/CutRemeshing.h"
#include "Cutting/Separation.h"
#include "Cutting/SurfaceIndex.h"

namespace kerf {
namespace {

constexpr double kDeformedAngle_deg = 0.6;
constexpr int kRings = 2;  // around the tetrahedra that S crosses: room for snapping and smoothing

double AngleOf(double cosine) {
  return cosine > 1 ? 0 : std::acos(std::clamp(cosine, -1.0, 1.0)) * 180 / M_PI;
}

struct Chosen {
  std::vector<Index> tets;  // ascending
  std::vector<char> inner;  // vertices whose tetrahedra are all chosen
};

/// Tetrahedra whose box meets S.
std::vector<Index> TetsNear(const TetMesh& mesh, const CutSurface& surface,
                            const SurfaceIndex& index) {
  const Eigen::RowVector3d low = surface.points.colwise().minCoeff();
  const Eigen::RowVector3d high = surface.points.colwise().maxCoeff();
  std::vector<Index> near;
  for (Index t = 0; t < mesh.TetCount(); ++t) {
    const auto v = mesh.tets.row(t);
    Eigen::RowVector3d tet_low = mesh.rest.row(v[0]), tet_high = tet_low;
    for (int k = 1; k < 4; ++k) {
      tet_low = tet_low.cwiseMin(mesh.rest.row(v[k]));
      tet_high = tet_high.cwiseMax(mesh.rest.row(v[k]));
    }
    if ((tet_low.array() > high.array()).any() || (tet_high.array() < low.array()).any()) continue;
    if (index.MeetsBox(tet_low.transpose(), tet_high.transpose())) near.push_back(t);
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
};

Attempt Try(const CutPatch& before, const SurfaceIndex& surface, const RemeshingOptions& options,
            bool snapping) {
  Attempt attempt{before, {}, 0, 180, 180};
  RemeshingOptions used = options;
  if (!snapping) used.snap_fraction = used.accept_fraction = 0;
  attempt.snapped = SnapVertices(surface, used, before, &attempt.patch);
  SplitCrossedEdges(surface, &attempt.patch);
  if (snapping) ImprovePatch(surface, used, before, &attempt.patch);
  attempt.separation = OpenFacesOnS(surface, &attempt.patch);
  const CutPatch& patch = attempt.patch;
  for (std::size_t t = 0; t < patch.tets.size(); ++t) {
    if (!patch.tets[t].changed) continue;
    attempt.angle_deg =
        std::min(attempt.angle_deg, AngleOf(patch.WorstCosine(static_cast<int>(t))));
    if (patch.deformed)
      attempt.angle_current_deg = std::min(attempt.angle_current_deg,
                                           AngleOf(patch.WorstCosineCurrent(static_cast<int>(t))));
  }
  return attempt;
}

TopologyChange Unchanged(const TetMesh& mesh) {
  TopologyChange change;
  change.mesh = mesh;
  change.vertex_parents.resize(mesh.VertexCount());
  change.vertex_weights = Weights4::Zero(mesh.VertexCount(), 4);
  change.vertex_weights.col(0).setOnes();
  for (Index v = 0; v < mesh.VertexCount(); ++v) change.vertex_parents[v].fill(v);
  change.parent_tet.resize(mesh.TetCount());
  std::iota(change.parent_tet.begin(), change.parent_tet.end(), 0);
  change.kept_tet = change.parent_tet;
  return change;
}

/// Puts the patch back into the mesh. Unchanged tetrahedra and all old vertices keep their numbers.
TopologyChange Assemble(const TetMesh& mesh, const CutPatch& before, const Attempt& attempt) {
  const CutPatch& patch = attempt.patch;
  TopologyChange change = Unchanged(mesh);
  change.changed = true;
  std::vector<Index> number(patch.vertices.size());
  Index vertex_count = mesh.VertexCount();
  for (std::size_t v = 0; v < patch.vertices.size(); ++v)
    number[v] = patch.vertices[v].old_vertex >= 0 ? patch.vertices[v].old_vertex : vertex_count++;
  change.mesh.rest.conservativeResize(vertex_count, 3);
  change.vertex_weights.conservativeResize(vertex_count, 4);
  change.vertex_parents.resize(vertex_count);
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
  std::vector<Index> places;  // of changed old tetrahedra
  for (std::size_t t = 0; t < before.tets.size(); ++t)
    if (patch.tets[t].changed) {
      places.push_back(before.old_tet[t]);
      change.kept_tet[before.old_tet[t]] = -1;
    }
  const Index fresh = static_cast<Index>(
      std::count_if(patch.tets.begin(), patch.tets.end(), [](const auto& t) { return t.changed; }));
  Index tet_count = mesh.TetCount();
  change.mesh.tets.conservativeResize(tet_count + fresh - static_cast<Index>(places.size()), 4);
  change.mesh.region.resize(change.mesh.tets.rows());
  change.parent_tet.resize(change.mesh.tets.rows());
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

void ReportComponents(const TetMesh& mesh, CutReport* report) {
  std::vector<Index> root(mesh.VertexCount());
  std::iota(root.begin(), root.end(), 0);
  auto find = [&](Index i) {
    while (root[i] != i) i = root[i] = root[root[i]];
    return i;
  };
  for (Index t = 0; t < mesh.TetCount(); ++t)
    for (int k = 1; k < 4; ++k) {
      const Index a = find(mesh.tets(t, 0)), b = find(mesh.tets(t, k));
      root[std::max(a, b)] = std::min(a, b);
    }
  std::vector<int> component(mesh.VertexCount(), -1);
  report->component_volume_mm3.clear();
  for (Index t = 0; t < mesh.TetCount(); ++t) {
    int& c = component[find(mesh.tets(t, 0))];
    if (c < 0) {
      c = static_cast<int>(report->component_volume_mm3.size());
      report->component_volume_mm3.push_back(0);
    }
    report->component_volume_mm3[c] += TetVolume(mesh.rest, mesh.tets, t);
  }
  report->components = static_cast<int>(report->component_volume_mm3.size());
}

}  // namespace

TetCutter::TetCutter(CutOptions options) : options_(options) {}

TopologyChange TetCutter::Cut(const TetMesh& mesh, const CutSurface& surface, CutReport* report,
                              const Points* positions) {
  CutReport unused;
  CutReport& out = report ? *report : unused;
  out = {};
  auto refuse = [&](const char* reason) {
    out.reason = reason;
    ReportComponents(mesh, &out);
    return Unchanged(mesh);
  };
  const SurfaceIndex index(surface);
  if (index.Empty()) return refuse("the separation surface is empty");
  const std::vector<Index> near = TetsNear(mesh, surface, index);
  if (near.empty()) return refuse("the separation surface does not meet the organ");
  const std::vector<char> all_inner(mesh.VertexCount(), 1);
  const std::vector<Index> work = TetsToWorkOn(index, CutPatch(mesh, nullptr, near, all_inner));
  if (work.empty()) return refuse("the separation surface separates nothing new");
  const Chosen chosen = WithRings(mesh, work, kRings);
  const CutPatch before(mesh, positions, chosen.tets, chosen.inner);

  double before_deg = 180, before_current_deg = 180;
  for (std::size_t t = 0; t < before.tets.size(); ++t) {
    before_deg = std::min(before_deg, AngleOf(before.WorstCosine(static_cast<int>(t))));
    before_current_deg =
        std::min(before_current_deg, AngleOf(before.WorstCosineCurrent(static_cast<int>(t))));
  }
  const double required_deg = std::min(options_.min_dihedral_deg, before_deg);
  const double required_current_deg = std::min(kDeformedAngle_deg, 0.5 * before_current_deg);

  std::optional<Attempt> best;
  bool separates = false;
  for (double factor : {1.0, 0.7, 1.25, 0.45}) {
    RemeshingOptions remeshing;
    remeshing.snap_fraction = factor * options_.snap_fraction;
    Attempt attempt = Try(before, index, remeshing, options_.snapping);
    if (attempt.separation.faces.empty()) continue;
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
  ReportComponents(change.mesh, &out);
  return change;
}

}  // namespace kerf
