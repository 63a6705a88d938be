#pragma once

#include <cstdint>
#include <vector>

#include "Core/SurfaceMesh.h"
#include "Core/TopologyChange.h"
#include "Geometry/SurfaceTree.h"

namespace kerf {

/// The cut line where it lies on the organ: `line` (at rest, it may run beside and beyond the
/// organ) projected along `direction` to the first hit of the rest surface, in steps of `step_mm`;
/// points that miss the organ are dropped.
/// @return M×3 on the rest surface, in order, mm; empty when the whole line misses
Points LineOnSurface(const CutPolyline& line, const Vec3& direction,
                     const SurfaceTree& rest_surface, double step_mm = 1.0);

/// `line` led on to `tip` from its last point (or its first).
Points LedOn(const Points& line, bool at_end, const Vec3& tip);

/// `line` without its last (or first) `by_mm`. @return no rows when it is not longer than that
Points Shortened(const Points& line, bool at_end, double by_mm);

/// Distance of `p` from a line of points, mm; 1e30 for fewer than two points.
double DistanceToLine(const Points& line, const Vec3& p);

/// Which triangles of a cut organ's boundary are faces of a cut: those whose centre lies off the
/// uncut organ's surface.
/// @param boundary_rest boundary of the cut mesh at rest; @param uncut tree over the uncut organ's
/// rest surface
std::vector<std::uint8_t> CutFaceFlags(const SurfaceMesh& boundary_rest, const SurfaceTree& uncut);

}  // namespace kerf
