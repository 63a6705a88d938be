#pragma once

#include <array>
#include <vector>

#include "Cutting/CutPatch.h"
#include "Cutting/SurfaceIndex.h"

namespace kerf {

/// A face with all corners on S that has tissue on either side of S.
struct FaceOnS {
  std::array<int, 3> v;  ///< ascending
  std::array<int, 2> tet;
  double area_mm2;
  bool open = true;
};
/// Along S and inside its extent; ascending by their corners.
std::vector<FaceOnS> FacesOnS(const SurfaceIndex& surface, const CutPatch& patch);

/// Which corner of tetrahedron t is none of the face's.
int CornerOpposite(const CutPatch& patch, int t, const std::array<int, 3>& face);

}  // namespace kerf
