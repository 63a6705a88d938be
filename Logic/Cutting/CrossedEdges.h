#pragma once

#include <vector>

#include "Cutting/CoreNear.h"
#include "Cutting/CutPatch.h"
#include "Cutting/SurfaceIndex.h"

namespace kerf {

/// An edge a < b that S crosses at a + t (b − a) and that belongs to a tetrahedron which S cuts
/// through: all of its edges between the two sides are crossed. Edges at the rim of S that only
/// enter a tetrahedron open nothing and are left for a later increment.
struct CrossedEdge {
  int a, b;
  double t;
};
/// Ascending by (a, b); only edges of tetrahedra in the core.
std::vector<CrossedEdge> EdgesCutThrough(const SurfaceIndex& surface, const CutPatch& patch,
                                         const CoreNear& near);

/// Parameter where S crosses the edge a–b and has to split it, or −1.
double CrossingToSplit(const SurfaceIndex& surface, const CutPatch& patch, int a, int b);

/// Bisects every edge that S still crosses. False: given up half-way, when the patch had
/// `most_vertices`; throw it away.
[[nodiscard]] bool SplitCrossedEdges(const SurfaceIndex& surface, const CoreNear& near,
                                     std::size_t most_vertices, CutPatch* patch);

}  // namespace kerf
