#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "Meshing/DomainMesher.h"
#include "Meshing/ImproveDihedral.h"
#include "Meshing/TetMesher.h"

namespace kerf {
namespace {

double Volume_mm3(const TetMesh& mesh) {
  double volume = 0.0;
  for (Index t = 0; t < mesh.TetCount(); ++t) volume += TetVolume(mesh.rest, mesh.tets, t);
  return volume;
}

/// Better first: manifold, then dihedral angle up to what was asked.
bool Better(const MeshQuality& a, const MeshQuality& b, double enough_deg) {
  if (a.manifold_boundary != b.manifold_boundary) return a.manifold_boundary;
  return std::min(a.smallest_dihedral_deg, enough_deg) >
         std::min(b.smallest_dihedral_deg, enough_deg);
}

}  // namespace

TetMesh LargestComponent(const TetMesh& mesh, const std::string& where, Progress& progress) {
  std::vector<Index> component;
  const int count = TetComponents(mesh.tets, &component);
  if (count <= 1) return mesh;
  std::vector<double> volume(count, 0.0);
  for (Index t = 0; t < mesh.TetCount(); ++t)
    volume[component[t]] += TetVolume(mesh.rest, mesh.tets, t);
  const int largest =
      static_cast<int>(std::max_element(volume.begin(), volume.end()) - volume.begin());
  const double total = std::accumulate(volume.begin(), volume.end(), 0.0);
  progress.Warn(where + ": " + std::to_string(count - 1) +
                " small part(s) of the mesh are left out (" +
                std::to_string(100.0 * (1.0 - volume[largest] / total)) + " % of the volume)");
  std::vector<Index> number(mesh.VertexCount(), -1), vertices, tets;
  for (Index t = 0; t < mesh.TetCount(); ++t) {
    if (component[t] != largest) continue;
    tets.push_back(t);
    for (int k = 0; k < 4; ++k) {
      Index& n = number[mesh.tets(t, k)];
      if (n >= 0) continue;
      n = static_cast<Index>(vertices.size());
      vertices.push_back(mesh.tets(t, k));
    }
  }
  TetMesh out;
  out.rest.resize(vertices.size(), 3);
  for (std::size_t v = 0; v < vertices.size(); ++v) out.rest.row(v) = mesh.rest.row(vertices[v]);
  out.tets.resize(tets.size(), 4);
  for (std::size_t t = 0; t < tets.size(); ++t) {
    for (int k = 0; k < 4; ++k) out.tets(t, k) = number[mesh.tets(tets[t], k)];
    out.region.push_back(mesh.region[tets[t]]);
  }
  return out;
}

TetMesh MeshToCount(const DomainMesher& domain, const std::string& where,
                    const MeshingOptions& options, Progress& progress, MeshingReport* report) {
  const double wanted = options.tetrahedra, target_mm3 = domain.Volume_mm3();
  MesherRun run;
  // Delaunay cells of circumradius ≤ h hold about h³/6.5 mm³ each on average.
  run.edge_mm = std::cbrt(6.5 * target_mm3 / wanted);
  const double largest_edge = 0.5 * std::cbrt(target_mm3);
  run.edge_mm = std::min(run.edge_mm, largest_edge);
  Index last_count = 0;
  // Count and enclosed volume settle together; refinement alone takes a tenth of a second.
  for (int i = 0; i < 8; ++i) {
    progress.Report(0.1 + 0.05 * i, "finding the cell size");
    progress.ThrowIfCancelled();
    const TetMesh mesh = domain.Mesh(run, progress);
    if (mesh.TetCount() == 0) {
      run.edge_mm *= 0.6;
      continue;
    }
    const double ratio = mesh.TetCount() / wanted;
    const SurfaceMesh boundary = BoundarySurface(mesh, mesh.rest);
    const double volume = Volume_mm3(mesh);
    const double volume_error = volume / target_mm3 - 1.0;
    // Thin bodies need cells of their thickness: beyond that a larger size changes nothing.
    const bool at_limit = ratio > 1.0 && (run.edge_mm >= largest_edge ||
                                          std::abs(mesh.TetCount() - last_count) < 0.02 * wanted);
    last_count = mesh.TetCount();
    if ((std::abs(ratio - 1.0) < 0.04 || at_limit) &&
        (!domain.HasOffset() || std::abs(volume_error) < 0.002))
      break;
    if (!at_limit)
      run.edge_mm = std::min(largest_edge, run.edge_mm * std::clamp(std::cbrt(ratio), 0.5, 2.0));
    run.offset_mm -= std::clamp((volume - target_mm3) / boundary.Area(), -0.3, 0.3);
    run.offset_mm = std::clamp(run.offset_mm, -0.6, 0.6);
  }

  TetMesh best;
  std::optional<MeshQuality> best_quality;
  double best_edge = run.edge_mm;
  run.improve = true;
  // Other sizes near the right one give other meshes: the slivers and pinched edges of one are not
  // those of the next.
  const double factors[] = {1.0, 0.985, 1.015, 0.97, 1.03, 0.955, 1.045};
  const double edge = run.edge_mm;
  for (std::size_t i = 0; i < std::size(factors); ++i) {
    progress.Report(0.5 + 0.07 * i, "meshing");
    progress.ThrowIfCancelled();
    run.edge_mm = factors[i] * edge;
    run.sliver_bound_deg = options.min_dihedral_deg + 1.5;
    TetMesh mesh = domain.Mesh(run, progress);
    if (mesh.TetCount() == 0) continue;
    mesh = LargestComponent(mesh, where, progress);
    DihedralOptions dihedral;
    // A little more than asked, so that no rounding falls below.
    dihedral.wanted_deg = options.min_dihedral_deg + 0.5;
    dihedral.boundary_shift_mm = domain.HasOffset() ? 0.08 * run.edge_mm : 0.0;
    dihedral.interface_shift_mm = 0.15 * run.edge_mm;
    ImproveDihedral(dihedral, &mesh);
    const MeshQuality quality = MeasureQuality(mesh, mesh.rest);
    if (!best_quality || Better(quality, *best_quality, options.min_dihedral_deg)) {
      best = std::move(mesh);
      best_quality = quality;
      best_edge = run.edge_mm;
    }
    if (best_quality->manifold_boundary &&
        best_quality->smallest_dihedral_deg >= options.min_dihedral_deg)
      break;
  }
  if (!best_quality || best_quality->tets == 0)
    throw InputError(where, "", "too small or too thin to be meshed");
  if (!best_quality->manifold_boundary)
    throw InputError(where, "", "no mesh with a manifold boundary was found; the shape is pinched");
  if (best_quality->smallest_dihedral_deg < options.min_dihedral_deg)
    progress.Warn(where + ": smallest dihedral angle of the mesh is " +
                  std::to_string(best_quality->smallest_dihedral_deg) + " degrees");
  if (report) {
    report->quality = *best_quality;
    report->input_volume_mm3 = target_mm3;
    report->volume_error = best_quality->volume_mm3 / target_mm3 - 1.0;
    report->edge_mm = best_edge;
  }
  return best;
}

}  // namespace kerf
