#include "Cutting/PatchOpening.h"

#include <algorithm>
#include <numeric>

#include "Cutting/DisjointSets.h"

namespace kerf {

PatchOpening::PatchOpening(const CutPatch& closed, const std::vector<FaceOnS>& faces)
    : patch(closed) {
  origin.resize(patch.vertices.size());
  std::iota(origin.begin(), origin.end(), 0);
  std::vector<int> count(patch.vertices.size(), 0);
  for (const FaceOnS& face : faces)
    if (face.open)
      for (int v : face.v) ++count[v];
  ShortLists faces_of;
  faces_of.Reserve(count.size(), 3 * faces.size());
  for (int faces_of_vertex : count) faces_of.Add(faces_of_vertex);
  for (std::size_t f = 0; f < faces.size(); ++f)
    if (faces[f].open)
      for (int v : faces[f].v) faces_of.Push(v, static_cast<int>(f));
  for (int v = 0; v < static_cast<int>(count.size()); ++v)
    if (count[v] > 0) {
      touched.push_back(v);
      Duplicate(closed, v, faces_of[v], faces);
    }
}

void PatchOpening::Duplicate(const CutPatch& closed, int v, const ShortLists::List& open,
                             const std::vector<FaceOnS>& faces) {
  const ShortLists::List star = closed.star[v];
  std::vector<CutPatch::FaceAt> sides;
  closed.FacesAt(v, &sides);
  std::vector<std::uint64_t> open_edges;  // of the open faces, opposite to v
  for (int f : open) {
    const auto& face = faces[f].v;
    open_edges.push_back(v == face[0] ? EdgeKey(face[1], face[2])
                                      : EdgeKey(face[0], v == face[1] ? face[2] : face[1]));
  }
  DisjointSets joined(star.size());
  for (const CutPatch::FaceAt& side : sides)
    if (side.other >= 0 &&
        std::find(open_edges.begin(), open_edges.end(), side.edge) == open_edges.end())
      joined.Join(side.tet, side.other);
  std::vector<int> vertex_of(star.size(), -1);
  vertex_of[joined.Find(0)] = v;
  for (int i = 0; i < star.size(); ++i) {
    const Index r = joined.Find(i);
    if (vertex_of[r] < 0) {
      vertex_of[r] = static_cast<int>(patch.vertices.size());
      patch.vertices.push_back(closed.vertices[v]);
      patch.vertices.back().old_vertex = -1;
      patch.star.Add(star.size());
      origin.push_back(v);
      touched.push_back(vertex_of[r]);
      ++duplicated;
    }
    if (vertex_of[r] == v) continue;
    for (int& w : patch.tets[star[i]].v)
      if (w == v) w = vertex_of[r];
    patch.tets[star[i]].changed = true;
    patch.star.Push(vertex_of[r], star[i]);
  }
  if (duplicated > 0) patch.star.RemoveIf(v, [&](int t) { return !patch.Has(t, v); });
}

bool Pinched(const CutPatch& patch, int v) {
  std::vector<CutPatch::FanFace> fan;
  patch.BoundaryFan(v, &fan);
  if (fan.empty()) return false;
  // One closed ring?
  std::sort(fan.begin(), fan.end(),
            [](const CutPatch::FanFace& a, const CutPatch::FanFace& b) { return a[0] < b[0]; });
  for (std::size_t i = 0; i + 1 < fan.size(); ++i)
    if (fan[i][0] == fan[i + 1][0]) return true;
  int at = fan[0][0];
  std::size_t steps = 0;
  do {
    const auto next =
        std::lower_bound(fan.begin(), fan.end(), at,
                         [](const CutPatch::FanFace& face, int end) { return face[0] < end; });
    if (next == fan.end() || (*next)[0] != at) return true;
    at = (*next)[1];
    ++steps;
  } while (at != fan[0][0] && steps <= fan.size());
  return steps != fan.size();
}

}  // namespace kerf
