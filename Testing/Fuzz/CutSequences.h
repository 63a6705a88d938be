#pragma once

#include <optional>
#include <string>
#include <vector>

#include "Core/TopologyChange.h"

namespace kerf::testing {

struct CutPlane {
  Vec3 through, normal;
};

/// One random sequence of cuts on one mesh of the zoo; everything follows from the seed.
struct CutSequence {
  TetMesh mesh;
  Points positions;                                ///< deformed, N×3; empty: at rest
  std::vector<CutSurface> surfaces;                ///< the whole S so far, one for each increment
  std::vector<std::optional<CutPlane>> completes;  ///< this increment parts all tissue along it
  std::vector<int> cut;                            ///< increment → which cut it belongs to
  std::string name;
};
CutSequence MakeCutSequence(unsigned seed);
/// The same on a mesh of one's own.
CutSequence MakeCutSequence(unsigned seed, TetMesh mesh, const std::string& name);

struct CutSequenceResult {
  int increments = 0, done = 0, refused = 0;
  int partial = 0, partial_complete = 0, partial_joined = 0;  ///< cut, but said not to be all of S
  int complete = 0, missed_separations = 0;  ///< complete cuts, and those that left tissue joined
  int complete_across = 0, missed_across = 0;
  double smallest_dihedral_deg = 180, smallest_deformed_deg = 180;
  double smallest_volume_share = 1;                 ///< in mean tetrahedra of the mesh that was cut
  double most_new_vertices = 0, most_new_tets = 0;  ///< for each tetrahedron with something to cut
  int chips = 0;
  std::string failure;  ///< empty: every guarantee held after every increment
};
CutSequenceResult RunCutSequence(const CutSequence& sequence);

}  // namespace kerf::testing
