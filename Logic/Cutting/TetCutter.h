#pragma once

#include <string>
#include <vector>

#include "Core/TopologyChange.h"
#include "Cutting/CutMemory.h"

namespace kerf {

struct CutOptions {
  double snap_fraction =
      0.3;  ///< a vertex nearer to S than this fraction of its edge is moved onto S
  double min_dihedral_deg = 3.0;   ///< guarantee at rest
  double min_volume_share = 1e-7;  ///< guarantee: of the mean tetrahedron of the mesh handed in
  double max_new_vertices = 4;     ///< guarantee: for each of CutReport::crossed_tets
  double max_new_tets = 8;         ///< guarantee: for each of CutReport::crossed_tets
  int rounds = 3;        ///< what is cut may leave S to cut through elements that it only entered
  bool snapping = true;  ///< off = plain subdivision (for comparison only)
};

struct CutReport {
  bool done = false;       ///< false: nothing changed, `reason` says why
  bool partial = false;    ///< a part of S stays uncut in the organ, now or from an earlier call;
                           ///< with `done` the rest is cut, without it nothing new was
  std::string reason;      ///< why nothing, or not all of S, was cut; else empty
  Index crossed_tets = 0;  ///< of the mesh handed in, with something to cut: the increment's size
  Index new_vertices = 0, new_tets = 0, snapped_vertices = 0, duplicated_vertices = 0;
  double cut_area_mm2 = 0.0;           ///< new separation faces, one side
  double smallest_dihedral_deg = 0.0;  ///< of the tetrahedra made
  double smallest_volume_share = 0.0;  ///< of them, in mean tetrahedra of the mesh handed in
  int chips = 0;  ///< pieces of up to three mean tetrahedra that S cuts off, and that stay joined
  int components = 1;
  std::vector<double> component_volume_mm3;
};

/// Cuts a tetra mesh at rest along separation surfaces, increment by increment, by node snapping
/// and local remeshing. Remembers what is already separated, so that a growing S is cut only where
/// it is new. Guarantees, in every build: no inverted element, smallest dihedral angle ≥
/// options.min_dihedral_deg (where the input has ≥ 8°), volume kept to 1e-6, 2-manifold boundary,
/// deterministic. No tetrahedron is made smaller than options.min_volume_share of the mean one (or
/// than the smallest around S was), and no more than options.max_new_vertices and max_new_tets are
/// added for each tetrahedron with something to cut. An increment that cannot keep all this leaves
/// the mesh as it was. Where S had to stay uncut it is tried again with every increment that comes
/// near, and when the same S is handed in again. Sheets of S that do not hang together are cut one
/// after the other, so that they may cross.
class TetCutter {
 public:
  /// @throws UsageError where an option is negative or not a number
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
  CutOptions options_;
  CutMemory memory_;
};

}  // namespace kerf
