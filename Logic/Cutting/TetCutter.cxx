#include "Cutting/TetCutter.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>
#include <optional>

#include "Core/Errors.h"
#include "Cutting/CutAssembly.h"
#include "Cutting/CutAttempt.h"
#include "Cutting/CutPatch.h"
#include "Cutting/CutRegion.h"
#include "Cutting/CutSheet.h"
#include "Cutting/Separation.h"

namespace kerf {
namespace {

constexpr double kContextEdges =
    5;  // mean edges around what is new in S in which the old S still counts
constexpr double kSlack = 1e-4;  // mean edges: a face this near to S may count as on it
const char* const kNothingNew = "the separation surface separates nothing new";
const char* const kBadlyShaped = "no remeshing keeps the elements well shaped and few";
const char* const kWouldTouchItself = "the organ would touch itself in a single point";
const char* const kRoundsRanOut = "what was cut left more to cut, several times over";
constexpr int kRings = 2;  // around the tetrahedra that S crosses: room for snapping and smoothing

void ThrowIfBroken(const TetMesh& mesh, const CutSurface& surface, const Points* positions) {
  const char* const file = "separation surface";
  for (Index i = 0; i < surface.points.rows(); ++i)
    if (!surface.points.row(i).allFinite())
      throw InputError(file, "point " + std::to_string(i), "has a coordinate that is not finite");
  for (Index t = 0; t < surface.triangles.rows(); ++t)
    for (int k = 0; k < 3; ++k)
      if (surface.triangles(t, k) < 0 || surface.triangles(t, k) >= surface.points.rows())
        throw InputError(file, "triangle " + std::to_string(t),
                         "names point " + std::to_string(surface.triangles(t, k)) + " of " +
                             std::to_string(surface.points.rows()));
  if (positions && positions->rows() != mesh.VertexCount())
    throw InputError("current positions", "", "are not one for each vertex of the mesh");
}

}  // namespace

TetCutter::TetCutter(CutOptions options) : options_(options) {
  for (const double option :
       {options.snap_fraction, options.min_dihedral_deg, options.min_volume_share,
        options.max_new_vertices, options.max_new_tets})
    if (!std::isfinite(option) || option < 0.0)
      throw UsageError("cutting: an option is negative or not a number");
  if (options.rounds < 1) throw UsageError("cutting: no round");
}

TopologyChange TetCutter::Cut(const TetMesh& mesh, const CutSurface& surface, CutReport* report,
                              const Points* positions) {
  CutReport unused;
  CutReport& out = report ? *report : unused;
  out = {};
  ThrowIfBroken(mesh, surface, positions);
  const bool known = memory_.Knows(mesh);
  const std::vector<double> pieces_before =
      known ? memory_.component_volume_mm3 : ComponentVolumes_mm3(mesh);
  const auto report_components = [&](std::vector<double> volumes_mm3) {
    out.component_volume_mm3 = std::move(volumes_mm3);
    out.components = static_cast<int>(out.component_volume_mm3.size());
  };
  const double edge_mm = MeanEdge_mm(mesh);
  const CutProgress progress(surface, known ? &memory_ : nullptr, kContextEdges * edge_mm);
  const auto remember = [&](const TetMesh& result, const std::vector<char>& left) {
    progress.Remember(left, &memory_);
    memory_.vertices = result.VertexCount();
    memory_.tets = result.TetCount();
    memory_.component_volume_mm3 = out.component_volume_mm3;
  };
  const auto refuse = [&](const char* reason, bool partial) {
    out.reason = reason;
    out.partial = partial;
    report_components(pieces_before);
    return Unchanged(mesh, mesh.VertexCount(), mesh.TetCount());
  };

  // Where S is new, and the part of S around it.
  const Index triangles = static_cast<Index>(surface.triangles.rows());
  const CutSurface fresh = Part(surface, [&](Index t) { return progress.fresh[t]; });
  if (fresh.triangles.rows() == 0)
    return refuse(triangles == 0 ? "the separation surface is empty" : kNothingNew, false);
  CutBox region;
  for (Index i = 0; i < fresh.points.rows(); ++i) region.Add(fresh.points.row(i));
  CutBox context = region;
  region.Grow(known ? edge_mm : kSlack * edge_mm);
  context.Grow(kContextEdges * edge_mm);

  // Sheet by sheet: a vertex on one of them is as good as any other where another crosses.
  const std::vector<int> sheet_of = SheetsOf(surface);
  std::vector<CutSheet> sheets;
  bool meets = false;
  for (int s = 0; s <= *std::max_element(sheet_of.begin(), sheet_of.end()); ++s) {
    const CutSurface part = Part(surface, [&](Index t) {
      return sheet_of[t] == s && context.Meets(BoxOf(surface.points, surface.triangles.row(t)));
    });
    bool is_new = false;
    for (Index t = 0; t < triangles; ++t) is_new |= sheet_of[t] == s && progress.fresh[t];
    sheets.emplace_back(part, is_new, mesh, region, kSlack * edge_mm);
    meets = meets || sheets.back().meets;
  }
  std::vector<Index> work;
  for (const CutSheet& sheet : sheets) {
    std::vector<Index> both;
    std::set_union(work.begin(), work.end(), sheet.work.begin(), sheet.work.end(),
                   std::back_inserter(both));
    work = std::move(both);
  }
  if (work.empty()) {
    TopologyChange unchanged = refuse(
        meets ? kNothingNew : "the separation surface does not meet the organ", progress.Waits());
    remember(mesh, std::vector<char>(triangles, 0));
    return unchanged;
  }
  const ChosenTets chosen = WithRings(mesh, work, kRings);
  CutPatch before(mesh, positions, chosen.tets, chosen.inner);
  const double mean_mm3 =
      std::accumulate(pieces_before.begin(), pieces_before.end(), 0.0) / mesh.TetCount();
  out.crossed_tets = static_cast<Index>(work.size());
  const CutDemands demands = DemandsOn(before, out.crossed_tets, mean_mm3, options_);

  std::optional<CutPatch> cut;  // what has become of it
  std::vector<OpenedFace> opened;
  bool same_pieces = true;
  int cuts = 0;
  const char* left = nullptr;  // why something is
  // What is left of old sheets comes last: it may open where a new one has opened more.
  for (bool new_ones : {true, false})
    for (CutSheet& sheet : sheets) {
      if (sheet.fresh != new_ones || sheet.work.empty()) continue;
      std::vector<int> core = (cut ? *cut : before).TetsOutOf(sheet.work);
      std::vector<std::array<int, 2>> kept;
      int chips = 0;
      for (int round = 0; round < options_.rounds && !core.empty(); ++round) {
        CutPatch& patch = cut ? *cut : before;
        patch.MarkCore(core);
        std::optional<CutAttempt> best = CutAlong(&sheet, before, &patch, options_, demands);
        if (!best) {
          if (!sheet.refused) core.clear();  // S only touches it
          break;
        }
        ++cuts;
        cut = std::move(best->patch);
        opened = std::move(best->separation.faces);
        same_pieces = same_pieces && best->separation.same_pieces;
        out.snapped_vertices += best->snapped;
        out.duplicated_vertices += best->separation.duplicated_vertices;
        out.cut_area_mm2 += best->separation.area_mm2;
        out.smallest_dihedral_deg = best->angle_deg;
        out.smallest_volume_share = best->smallest_mm3 / mean_mm3;
        chips = best->separation.chips;
        kept.insert(kept.end(), best->separation.kept.begin(), best->separation.kept.end());
        core.clear();
        if (best->separation.stuck) core = TetsToWorkOn(sheet.index, *cut);
      }
      out.chips += chips;
      const CutPatch& now = cut ? *cut : before;
      sheet.Leave(now, core);
      sheet.Leave(now, StillJoined(now, kept));
      if (!sheet.left.empty() && left != kBadlyShaped)
        left = sheet.refused ? kBadlyShaped : core.empty() ? kWouldTouchItself : kRoundsRanOut;
    }
  if (cuts == 0) {
    if (!left && known) progress.SettleTriedAgain(&memory_);
    return refuse(left ? left : kNothingNew, left || progress.Waits());
  }
  out.partial = left || progress.Waits();
  if (out.partial) out.reason = left ? left : kBadlyShaped;

  TopologyChange change = Assemble(mesh, before, *cut, cuts > 1 ? OpenedFaces(*cut) : opened);
  out.done = true;
  out.new_vertices = change.mesh.VertexCount() - mesh.VertexCount();
  out.new_tets = change.mesh.TetCount() - mesh.TetCount();
  report_components(same_pieces ? pieces_before : ComponentVolumes_mm3(change.mesh));
  std::vector<char> is_left(triangles, 0);
  for (Index t = 0; t < triangles; ++t) {
    const CutBox box = BoxOf(surface.points, surface.triangles.row(t));
    for (const CutBox& uncut : sheets[sheet_of[t]].left) is_left[t] |= uncut.Meets(box);
  }
  remember(change.mesh, is_left);
  return change;
}

}  // namespace kerf
