#include "Cutting/Separation.h"

#include <algorithm>
#include <cmath>

#include "Cutting/DisjointSets.h"
#include "Cutting/FacesOnS.h"
#include "Cutting/PatchOpening.h"

namespace kerf {
namespace {

constexpr double kFront = 1.2;  // mean edges: the crack front is this near to the end of S

/// The pieces of a patch, by shared vertices.
class Pieces {
 public:
  explicit Pieces(const CutPatch& patch)
      : joined_(patch.vertices.size()), vertices_(static_cast<int>(patch.vertices.size())) {
    for (const auto& tet : patch.tets)
      for (int k = 1; k < 4; ++k) joined_.Join(tet.v[0], tet.v[k]);
  }
  int Find(int v) { return static_cast<int>(joined_.Find(v)); }
  int Count() {
    int count = 0;
    for (int v = 0; v < vertices_; ++v) count += Find(v) == v;
    return count;
  }

 private:
  DisjointSets joined_;
  int vertices_;
};

/// Pieces that the opening cuts off and that are no more than a few tetrahedra: marks their
/// tetrahedra. @return their number
int MarkChips(const CutPatch& patch, Pieces* pieces, std::vector<char>* chip) {
  std::vector<double> volume_of(patch.vertices.size(), 0);
  std::vector<char> anchored(patch.vertices.size(), 0);
  double volume = 0;
  for (std::size_t v = 0; v < patch.vertices.size(); ++v)
    if (patch.vertices[v].frozen) anchored[pieces->Find(static_cast<int>(v))] = 1;
  for (std::size_t t = 0; t < patch.tets.size(); ++t) {
    const double v = patch.Volume_mm3(static_cast<int>(t));
    volume += v;
    volume_of[pieces->Find(patch.tets[t].v[0])] += v;
  }
  const double small = 3 * volume / double(patch.tets.size());
  for (std::size_t t = 0; t < patch.tets.size(); ++t) {
    const int r = pieces->Find(patch.tets[t].v[0]);
    (*chip)[t] = !anchored[r] && volume_of[r] < small;
  }
  int chips = 0;
  for (std::size_t v = 0; v < patch.vertices.size(); ++v)
    chips += pieces->Find(static_cast<int>(v)) == static_cast<int>(v) && !anchored[v] &&
             volume_of[v] > 0 && volume_of[v] < small;
  return chips;
}

/// Does S end at this face, so that the crack front may?
bool AtEndOfS(const SurfaceIndex& surface, const CutPatch& patch, const FaceOnS& face) {
  Vec3 middle = Vec3::Zero();
  double size_mm = 0;
  for (int v : face.v) {
    middle += patch.vertices[v].rest / 3;
    size_mm += patch.vertices[v].size_mm / 3;
  }
  return surface.BorderWithin(middle, kFront * size_mm);
}

}  // namespace

std::vector<OpenedFace> OpenedFaces(const CutPatch& patch) {
  constexpr double kSamePlace = 1e-6;  // of the edge length
  struct Side {
    Vec3 middle;
    int tet, corner;
  };
  std::vector<Side> sides;
  for (std::size_t t = 0; t < patch.tets.size(); ++t)
    for (int k = 0; k < 4; ++k)
      if (patch.tets[t].opened >> k & 1) {
        Side side{Vec3::Zero(), static_cast<int>(t), k};
        for (int w : kFaces[k]) side.middle += patch.vertices[patch.tets[t].v[w]].rest / 3;
        sides.push_back(side);
      }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    return a.middle[0] != b.middle[0] ? a.middle[0] < b.middle[0] : a.tet < b.tet;
  });
  std::vector<OpenedFace> faces;
  for (std::size_t i = 0; i < sides.size(); ++i) {
    const auto& v = patch.tets[sides[i].tet].v;
    const double near_mm = kSamePlace * patch.vertices[v[0]].size_mm;
    for (std::size_t j = i + 1;
         j < sides.size() && sides[j].middle[0] <= sides[i].middle[0] + near_mm; ++j) {
      if ((sides[j].middle - sides[i].middle).norm() > near_mm) continue;
      const auto& w = patch.tets[sides[j].tet].v;
      OpenedFace face;
      face.tet_a = sides[i].tet;
      face.tet_b = sides[j].tet;
      int same = 0;
      for (int k = 0; k < 3; ++k) {
        face.a[k] = v[kFaces[sides[i].corner][k]];
        for (int corner : kFaces[sides[j].corner])
          if ((patch.vertices[face.a[k]].rest - patch.vertices[w[corner]].rest).norm() <= near_mm) {
            face.b[k] = w[corner];
            ++same;
          }
      }
      if (same == 3) faces.push_back(face);
    }
  }
  return faces;
}

SeparationReport OpenFacesOnS(const SurfaceIndex& surface, CutPatch* patch) {
  SeparationReport report;
  std::vector<FaceOnS> faces = FacesOnS(surface, *patch);
  while (true) {
    PatchOpening opening(*patch, faces);
    if (opening.duplicated == 0) return report;
    std::vector<char> bad(patch->vertices.size(), 0);
    const bool all_open = report.closed == 0;
    bool any = false;
    for (int v : opening.touched) {
      if (!Pinched(opening.patch, v)) continue;
      bad[opening.origin[v]] = 1;
      any = true;
      if (all_open) report.pinched.push_back(opening.origin[v]);
    }
    Pieces pieces(opening.patch);
    const int piece_count = pieces.Count();
    std::vector<char> chip(patch->tets.size(), 0);
    if (piece_count > 1)  // those left of the pass before are counted again
      report.chips = std::max(report.chips, MarkChips(opening.patch, &pieces, &chip));
    const Index closed_before = report.closed;
    for (FaceOnS& face : faces) {
      if (!face.open) continue;
      if (bad[face.v[0]] || bad[face.v[1]] || bad[face.v[2]]) {
        face.open = false;
        if (chip[face.tet[0]] == chip[face.tet[1]] && !AtEndOfS(surface, *patch, face))
          report.kept.push_back(face.tet);
      }
      if (chip[face.tet[0]] != chip[face.tet[1]]) {
        face.open = false;
        any = true;
      }
      report.closed += !face.open;
    }
    if (any && report.closed == closed_before)
      return report;  // no face left whose closing could mend it: nothing is opened
    if (any) continue;
    for (const FaceOnS& face : faces) {
      if (!face.open) continue;
      OpenedFace opened;
      opened.tet_a = face.tet[0];
      opened.tet_b = face.tet[1];
      for (int k = 0; k < 3; ++k) {
        opened.a[k] = opening.CornerOf(face.tet[0], face.v[k]);
        opened.b[k] = opening.CornerOf(face.tet[1], face.v[k]);
      }
      if (opened.a == opened.b) continue;  // at the front: both sides still have the same corners
      for (int k = 0; k < 3 && !report.stuck; ++k) {
        const auto& corner = opening.patch.vertices[opened.a[k]];
        report.stuck = opened.a[k] == opened.b[k] &&
                       !surface.BorderWithin(corner.rest, kFront * corner.size_mm);
      }
      report.faces.push_back(opened);
      report.area_mm2 += face.area_mm2;
      for (int t : face.tet) opening.patch.tets[t].opened |= 1 << CornerOpposite(*patch, t, face.v);
    }
    report.duplicated_vertices = opening.duplicated;
    report.same_pieces = piece_count == 1 || piece_count == Pieces(*patch).Count();
    *patch = std::move(opening.patch);
    return report;
  }
}

}  // namespace kerf
