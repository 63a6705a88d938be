#pragma once

#include <vector>

#include "Cutting/CutPatch.h"
#include "Cutting/FacesOnS.h"

namespace kerf {

/// A patch opened along faces: vertices are duplicated by the groups of their tetrahedra that hang
/// together through other faces, so that a crack front stays joined.
class PatchOpening {
 public:
  PatchOpening(const CutPatch& closed, const std::vector<FaceOnS>& faces);

  /// The corner of a tetrahedron that stems from v of the closed patch.
  int CornerOf(int t, int v) const {
    for (int w : patch.tets[t].v)
      if (origin[w] == v) return w;
    return -1;
  }

  CutPatch patch;
  std::vector<int> origin;   ///< vertex → vertex of the closed patch
  std::vector<int> touched;  ///< vertices at open faces, and their duplicates
  Index duplicated = 0;

 private:
  void Duplicate(const CutPatch& closed, int v, const ShortLists::List& open,
                 const std::vector<FaceOnS>& faces);
};

/// Does the boundary of the organ around v touch itself there?
bool Pinched(const CutPatch& patch, int v);

}  // namespace kerf
