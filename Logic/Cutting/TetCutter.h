#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "Core/TopologyChange.h"

namespace kerf {

struct CutOptions {
  double snap_fraction =
      0.3;  ///< a vertex nearer to S than this fraction of its edge is moved onto S
  double min_dihedral_deg = 3.0;  ///< guarantee at rest
  bool snapping = true;           ///< off = plain subdivision (for comparison only)
};

struct CutReport {
  bool done = false;     ///< false: nothing changed, `reason` says why
  bool partial = false;  ///< done, but a part of S had to stay uncut: `reason` says why
  std::string reason;    ///< why nothing, or not all of S, was cut; else empty
  Index new_vertices = 0, new_tets = 0, snapped_vertices = 0, duplicated_vertices = 0;
  double cut_area_mm2 = 0.0;  ///< new separation faces, one side
  double smallest_dihedral_deg = 0.0;
  int components = 1;
  std::vector<double> component_volume_mm3;
};

/// Cuts a tetra mesh at rest along separation surfaces, increment by increment, by node snapping
/// and local remeshing. Remembers what is already separated, so that a growing S is cut only where
/// it is new. Guarantees, in every build: no inverted element, smallest dihedral angle ≥
/// options.min_dihedral_deg (where the input has ≥ 8°), volume kept to 1e-6, 2-manifold boundary,
/// deterministic; an increment that cannot keep them leaves the mesh as it was. Sheets of S that do
/// not hang together are cut one after the other, so that they may cross.
class TetCutter {
 public:
  explicit TetCutter(CutOptions options = {});
  /// Cuts `mesh` along `surface`, the whole separation surface so far: parts that are already
  /// separated are skipped.
  /// @param positions current vertex positions; only used to keep elements positive as deformed,
  /// may be null
  /// @throws InputError naming the point or triangle: a coordinate that is not finite, a corner out
  /// of range; and where `positions` are not one for each vertex. Nothing is changed or remembered.
  TopologyChange Cut(const TetMesh& mesh, const CutSurface& surface, CutReport* report = nullptr,
                     const Points* positions = nullptr);

 private:
  struct Memory {                          ///< of the last call that left nothing to do
    std::vector<std::uint64_t> triangles;  ///< hashes of the surface's triangles, ascending
    Index vertices = -1, tets = -1;        ///< of the mesh it returned
    std::vector<double> component_volume_mm3;
  };
  bool Knows(const TetMesh& mesh) const {
    return memory_.vertices == mesh.VertexCount() && memory_.tets == mesh.TetCount();
  }

  CutOptions options_;
  Memory memory_;
};

}  // namespace kerf
