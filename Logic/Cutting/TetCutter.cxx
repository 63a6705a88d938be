#include "Cutting/TetCutter.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>

#include "Cutting/CutAssembly.h"
#include "Cutting/CutPatch.h"
#include "Cutting/CutRegion.h"
#include "Cutting/CutRemeshing.h"
#include "Cutting/Separation.h"
#include "Cutting/SurfaceIndex.h"

namespace kerf {
namespace {

constexpr double kAsMuch = 0.9;  // of the area that another attempt separates

constexpr double kDeformedAngle_deg = 0.6;
constexpr double kContextEdges =
    5;  // mean edges around what is new in S in which the old S still counts
constexpr double kSlack = 1e-4;  // mean edges: a face this near to S may count as on it
constexpr int kRounds = 3;  // what is cut may leave S to cut through elements that it only entered
constexpr int kRings = 2;   // around the tetrahedra that S crosses: room for snapping and smoothing

double AngleOf(double cosine) {
  return cosine > 1 ? 0 : std::acos(std::clamp(cosine, -1.0, 1.0)) * 180 / M_PI;
}

struct Attempt {
  CutPatch patch;
  SeparationReport separation;
  Index snapped = 0;
  double angle_deg = 0;           ///< smallest at rest among changed tetrahedra
  double angle_current_deg = 90;  ///< as deformed
  bool given_up = false;          ///< no end to the edges that S crosses
};

struct Angles {
  double rest_deg, current_deg;
};
template <class Take>
Angles SmallestAngles(const CutPatch& patch, Take take) {
  double worst = -1, worst_current = -1;
  for (std::size_t t = 0; t < patch.tets.size(); ++t) {
    if (!take(patch.tets[t])) continue;
    worst = std::max(worst, patch.WorstCosine(static_cast<int>(t)));
    if (patch.deformed)
      worst_current = std::max(worst_current, patch.WorstCosineCurrent(static_cast<int>(t)));
  }
  return {AngleOf(worst), AngleOf(worst_current)};
}

Attempt Try(const CutPatch& before, const CutPatch& start, const SurfaceIndex& sheet,
            const RemeshingOptions& options, bool snapping) {
  Attempt attempt{start, {}, 0, 180, 180, false};
  RemeshingOptions used = options;
  if (!snapping) used.snap_fraction = used.accept_fraction = 0;
  attempt.snapped = SnapVertices(sheet, used, before, &attempt.patch);
  if (!SplitCrossedEdges(sheet, &attempt.patch)) {
    attempt.given_up = true;
    return attempt;
  }
  if (snapping) ImprovePatch(sheet, used, before, &attempt.patch);
  attempt.separation = OpenFacesOnS(sheet, &attempt.patch);
  const Angles angles = SmallestAngles(attempt.patch, [](const auto& tet) { return tet.changed; });
  attempt.angle_deg = angles.rest_deg;
  attempt.angle_current_deg = angles.current_deg;
  return attempt;
}

/// A sheet of S with what it still has to cut.
struct Sheet {
  SurfaceIndex index;
  std::vector<Index> work;  ///< tetrahedra, ascending
  bool fresh;               ///< has triangles that were not there at the last call
  bool refused = false;
};

/// The best of several attempts to cut along one sheet. Nothing: refused if `sheet` says so,
/// otherwise there is nothing to separate.
std::optional<Attempt> CutAlong(Sheet* sheet, const CutPatch& before, const CutPatch& start,
                                const CutOptions& options, const Angles& required) {
  std::optional<Attempt> best;
  bool separates = false;
  int idle = 0;
  for (double factor : {1.0, 0.7, 1.25, 0.45}) {
    RemeshingOptions remeshing;
    remeshing.snap_fraction = factor * options.snap_fraction;
    Attempt attempt = Try(before, start, sheet->index, remeshing, options.snapping);
    // Where the boundary would touch itself in a vertex, that vertex is better not on S.
    for (int v : attempt.separation.pinched)
      if (v < static_cast<int>(start.vertices.size())) remeshing.off.push_back(v);
    if (!remeshing.off.empty() && options.snapping) {
      Attempt clear = Try(before, start, sheet->index, remeshing, true);
      const bool shaped = clear.angle_deg >= required.rest_deg &&
                          (!before.deformed || clear.angle_current_deg >= required.current_deg);
      if (!clear.given_up && shaped && clear.separation.closed < attempt.separation.closed &&
          clear.separation.area_mm2 >= kAsMuch * attempt.separation.area_mm2)
        attempt = std::move(clear);
    }
    if (attempt.given_up) {
      separates = true;
      continue;
    }
    if (attempt.separation.faces.empty()) {
      if (++idle == 2 && !separates) break;  // S only touches the organ
      continue;
    }
    separates = true;
    if (attempt.angle_current_deg < required.current_deg && before.deformed) continue;
    if (!best || attempt.angle_deg > best->angle_deg) best = std::move(attempt);
    if (best->angle_deg >= std::min(6.0, 2 * options.min_dihedral_deg) || !options.snapping) break;
  }
  if (best && options.snapping && best->angle_deg < required.rest_deg) best.reset();
  sheet->refused = separates && !best;
  return best;
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
    std::sort(triangles.begin(), triangles.end());
    memory_ = {std::move(triangles), result.VertexCount(), result.TetCount(),
               out.component_volume_mm3};
  };
  auto refuse = [&](const char* reason) {
    out.reason = reason;
    report_components(mesh, true);
    return Unchanged(mesh, mesh.VertexCount(), mesh.TetCount());
  };

  // Where S is new, and the part of S around it.
  const Index triangles = static_cast<Index>(surface.triangles.rows());
  std::vector<std::uint64_t> hashes(triangles);
  std::vector<char> is_fresh(triangles);
  for (Index t = 0; t < triangles; ++t) {
    hashes[t] = HashOfTriangle(surface, t);
    is_fresh[t] = !known || !std::binary_search(memory_.triangles.begin(), memory_.triangles.end(),
                                                hashes[t]);
  }
  const CutSurface fresh = Part(surface, [&](Index t) { return is_fresh[t]; });
  if (fresh.triangles.rows() == 0)
    return refuse(triangles == 0 ? "the separation surface is empty"
                                 : "the separation surface separates nothing new");
  const double edge_mm = MeanEdge_mm(mesh);
  CutBox region;
  for (Index i = 0; i < fresh.points.rows(); ++i) region.Add(fresh.points.row(i));
  CutBox context = region;
  region.Grow(known ? edge_mm : kSlack * edge_mm);
  context.Grow(kContextEdges * edge_mm);

  // Sheet by sheet: a vertex on one of them is as good as any other where another crosses.
  const std::vector<int> sheet_of = SheetsOf(surface);
  std::vector<Sheet> sheets;
  bool meets = false;
  for (int s = 0; s <= *std::max_element(sheet_of.begin(), sheet_of.end()); ++s) {
    Sheet sheet{
        SurfaceIndex(Part(surface,
                          [&](Index t) {
                            return sheet_of[t] == s &&
                                   context.Meets(BoxOf(surface.points, surface.triangles.row(t)));
                          })),
        {},
        false};
    const std::vector<Index> near = TetsNear(mesh, region, sheet.index, kSlack * edge_mm);
    meets = meets || !near.empty();
    if (!near.empty()) {
      const std::vector<char> all_inner(mesh.VertexCount(), 1);
      for (int t : TetsToWorkOn(sheet.index, CutPatch(mesh, nullptr, near, all_inner)))
        sheet.work.push_back(near[t]);
    }
    for (Index t = 0; t < triangles; ++t) sheet.fresh |= sheet_of[t] == s && is_fresh[t];
    sheets.push_back(std::move(sheet));
  }
  std::vector<Index> work;
  for (const Sheet& sheet : sheets) {
    std::vector<Index> both;
    std::set_union(work.begin(), work.end(), sheet.work.begin(), sheet.work.end(),
                   std::back_inserter(both));
    work = std::move(both);
  }
  if (work.empty()) {
    TopologyChange unchanged = refuse(!meets ? "the separation surface does not meet the organ"
                                             : "the separation surface separates nothing new");
    remember(mesh, std::move(hashes));
    return unchanged;
  }
  const ChosenTets chosen = WithRings(mesh, work, kRings);
  CutPatch before(mesh, positions, chosen.tets, chosen.inner);
  const Angles at_first = SmallestAngles(before, [](const auto&) { return true; });
  const Angles required{std::min(options_.min_dihedral_deg, at_first.rest_deg),
                        std::min(kDeformedAngle_deg, 0.5 * at_first.current_deg)};

  std::optional<CutPatch> cut;  // what has become of it
  std::vector<OpenedFace> opened;
  bool same_pieces = true, any_refused = false;
  int cuts = 0;
  // What is left of old sheets comes last: it may open where a new one has opened more.
  for (bool new_ones : {true, false})
    for (Sheet& sheet : sheets) {
      if (sheet.fresh != new_ones || sheet.work.empty()) continue;
      std::vector<int> core = (cut ? *cut : before).TetsOutOf(sheet.work);
      for (int round = 0; round < kRounds && !core.empty(); ++round) {
        CutPatch& patch = cut ? *cut : before;
        patch.MarkCore(core);
        std::optional<Attempt> best = CutAlong(&sheet, before, patch, options_, required);
        any_refused = any_refused || sheet.refused;
        if (round > 0) sheet.refused = false;  // the most of it is done
        if (!best) break;
        ++cuts;
        cut = std::move(best->patch);
        opened = std::move(best->separation.faces);
        same_pieces = same_pieces && best->separation.same_pieces;
        out.snapped_vertices += best->snapped;
        out.duplicated_vertices += best->separation.duplicated_vertices;
        out.cut_area_mm2 += best->separation.area_mm2;
        out.smallest_dihedral_deg = best->angle_deg;
        core.clear();
        if (best->separation.stuck) core = TetsToWorkOn(sheet.index, *cut);
      }
    }
  const char* const badly_shaped = "no remeshing keeps the elements well shaped";
  if (cuts == 0)
    return refuse(any_refused ? badly_shaped : "the separation surface separates nothing new");
  if (any_refused) out.reason = badly_shaped;

  TopologyChange change = Assemble(mesh, before, *cut, cuts > 1 ? OpenedFaces(*cut) : opened);
  out.done = true;
  out.new_vertices = change.mesh.VertexCount() - mesh.VertexCount();
  out.new_tets = change.mesh.TetCount() - mesh.TetCount();
  report_components(change.mesh, same_pieces);
  std::vector<std::uint64_t> settled;
  for (Index t = 0; t < triangles; ++t)
    if (!sheets[sheet_of[t]].refused) settled.push_back(hashes[t]);
  remember(change.mesh, std::move(settled));
  return change;
}

}  // namespace kerf
