#include "Cutting/TetCutter.h"

#include <algorithm>
#include <iterator>
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
constexpr int kRounds = 3;  // what is cut may leave S to cut through elements that it only entered
constexpr int kRings = 2;   // around the tetrahedra that S crosses: room for snapping and smoothing

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

TetCutter::TetCutter(CutOptions options) : options_(options) {}

TopologyChange TetCutter::Cut(const TetMesh& mesh, const CutSurface& surface, CutReport* report,
                              const Points* positions) {
  CutReport unused;
  CutReport& out = report ? *report : unused;
  out = {};
  ThrowIfBroken(mesh, surface, positions);
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
  std::vector<CutSheet> sheets;
  bool meets = false;
  for (int s = 0; s <= *std::max_element(sheet_of.begin(), sheet_of.end()); ++s) {
    const CutSurface part = Part(surface, [&](Index t) {
      return sheet_of[t] == s && context.Meets(BoxOf(surface.points, surface.triangles.row(t)));
    });
    bool is_new = false;
    for (Index t = 0; t < triangles; ++t) is_new |= sheet_of[t] == s && is_fresh[t];
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
    TopologyChange unchanged = refuse(!meets ? "the separation surface does not meet the organ"
                                             : "the separation surface separates nothing new");
    remember(mesh, std::move(hashes));
    return unchanged;
  }
  const ChosenTets chosen = WithRings(mesh, work, kRings);
  CutPatch before(mesh, positions, chosen.tets, chosen.inner);
  const PatchAngles required = RequiredAngles(before, options_);

  std::optional<CutPatch> cut;  // what has become of it
  std::vector<OpenedFace> opened;
  bool same_pieces = true, any_refused = false;
  int cuts = 0;
  // What is left of old sheets comes last: it may open where a new one has opened more.
  for (bool new_ones : {true, false})
    for (CutSheet& sheet : sheets) {
      if (sheet.fresh != new_ones || sheet.work.empty()) continue;
      std::vector<int> core = (cut ? *cut : before).TetsOutOf(sheet.work);
      for (int round = 0; round < kRounds && !core.empty(); ++round) {
        CutPatch& patch = cut ? *cut : before;
        patch.MarkCore(core);
        std::optional<CutAttempt> best = CutAlong(&sheet, before, &patch, options_, required);
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
  out.partial = any_refused;
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
