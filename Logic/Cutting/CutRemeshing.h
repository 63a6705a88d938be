#pragma once

#include "Cutting/CutPatch.h"
#include "Cutting/SurfaceIndex.h"

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

/// Marks vertices that lie on S and moves those near S onto it. Boundary vertices slide on the
/// boundary: the direction is orthogonal to their area vector, which keeps the volume exactly.
/// Returns the number of moved vertices.
Index SnapVertices(const SurfaceIndex& surface, const RemeshingOptions& options,
                   const CutPatch& before, CutPatch* patch);

/// Bisects every edge that S still crosses. False: given up half-way, after the patch had grown
/// several times over; throw it away.
[[nodiscard]] bool SplitCrossedEdges(const SurfaceIndex& surface, CutPatch* patch);

/// Moves vertices around tetrahedra below the goal: vertices on S within S, boundary vertices on
/// the boundary.
void ImprovePatch(const SurfaceIndex& surface, const RemeshingOptions& options,
                  const CutPatch& before, CutPatch* patch);

/// Marks vertices that lie on S already.
void MarkVerticesOnS(const SurfaceIndex& surface, CutPatch* patch);

/// An edge a < b that S crosses at a + t (b − a) and that belongs to a tetrahedron which S cuts
/// through: all of its edges between the two sides are crossed. Edges at the rim of S that only
/// enter a tetrahedron open nothing and are left for a later increment.
struct CrossedEdge {
  int a, b;
  double t;
};
/// Ascending by (a, b); only edges between vertices marked as core.
std::vector<CrossedEdge> EdgesCutThrough(const SurfaceIndex& surface, const CutPatch& patch);

/// Parameter where S crosses the edge a–b and has to split it, or −1.
double CrossingToSplit(const SurfaceIndex& surface, const CutPatch& patch, int a, int b);

}  // namespace kerf
