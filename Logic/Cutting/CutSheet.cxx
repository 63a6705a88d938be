#include "Cutting/CutSheet.h"

#include <algorithm>

#include "Cutting/CrossedEdges.h"
#include "Cutting/FacesOnS.h"

namespace kerf {

CutSheet::CutSheet(const CutSurface& part, bool is_fresh, const TetMesh& mesh, const CutBox& region,
                   double slack_mm)
    : index(part), fresh(is_fresh) {
  const std::vector<Index> tets = TetsNear(mesh, region, index, slack_mm);
  meets = !tets.empty();
  if (!meets) return;
  const CutPatch patch(mesh, nullptr, tets, std::vector<char>(mesh.VertexCount(), 1));
  std::vector<SurfaceNear> near;
  for (int t : TetsToWorkOn(index, patch, &near)) work.push_back(tets[t]);
  for (std::size_t v = 0; v < near.size(); ++v)
    if (near[v].triangle >= 0) known.push_back({patch.vertices[v].old_vertex, near[v]});
  std::sort(known.begin(), known.end(),
            [](const auto& a, const auto& b) { return a.first < b.first; });
}

CoreNear CutSheet::NearOf(const CutPatch& patch) const {
  std::vector<SurfaceNear> of_patch(patch.vertices.size());
  for (std::size_t v = 0; v < of_patch.size(); ++v) {
    const auto& vertex = patch.vertices[v];
    if (!vertex.core || vertex.moved || vertex.old_vertex < 0) continue;
    const auto at =
        std::lower_bound(known.begin(), known.end(), vertex.old_vertex,
                         [](const auto& place, Index number) { return place.first < number; });
    if (at != known.end() && at->first == vertex.old_vertex) of_patch[v] = at->second;
  }
  return CoreNear(index, patch, of_patch);
}

void CutSheet::Leave(const CutPatch& patch, const std::vector<int>& tets) {
  for (int t : tets) {
    CutBox box;
    for (int v : patch.tets[t].v) box.Add(patch.vertices[v].rest.transpose());
    left.push_back(box);
  }
}

std::vector<int> StillJoined(const CutPatch& patch, const std::vector<std::array<int, 2>>& pairs) {
  std::vector<int> joined;
  for (const auto& [t, u] : pairs) {
    const auto& v = patch.tets[t].v;
    if (std::count_if(v.begin(), v.end(), [&, u = u](int w) { return patch.Has(u, w); }) == 3)
      joined.push_back(t);
  }
  return joined;
}

std::vector<int> TetsToWorkOn(const SurfaceIndex& surface, CutPatch patch,
                              std::vector<SurfaceNear>* near_of_vertices) {
  for (auto& vertex : patch.vertices) vertex.core = true;
  const CoreNear near(surface, patch, {});
  MarkVerticesOnS(surface, near, &patch);
  std::vector<char> work(patch.tets.size(), 0);
  for (const FaceOnS& face : FacesOnS(surface, patch)) work[face.tet[0]] = work[face.tet[1]] = 1;
  for (const CrossedEdge& edge : EdgesCutThrough(surface, patch, near))
    for (int t : patch.Around(edge.a, edge.b)) work[t] = 1;
  std::vector<int> tets;
  for (std::size_t t = 0; t < work.size(); ++t)
    if (work[t]) tets.push_back(static_cast<int>(t));
  if (near_of_vertices) *near_of_vertices = near.All();
  return tets;
}

}  // namespace kerf
