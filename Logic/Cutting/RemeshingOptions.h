#pragma once

#include <vector>

namespace kerf {

/// How one attempt at an increment is made; several are tried.
struct RemeshingOptions {
  double snap_fraction = 0.3;  ///< see CutOptions
  double accept_fraction =
      0.08;  ///< a vertex that cannot be moved counts as on S when nearer (of its edge length)
  double slide_tolerance =
      0.04;  ///< how far a sliding boundary vertex may leave the old surface (of edge length)
  double keep_angle_deg = 9.0;  ///< snapping must not make angles smaller than this
  double goal_angle_deg = 9.0;  ///< tetrahedra below are improved
  int improvement_rounds = 3;
  std::vector<int> off;  ///< vertices of the patch that stay clear of S, and are moved if need be
};

}  // namespace kerf
