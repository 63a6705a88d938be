#pragma once

#include "Core/TopologyChange.h"

namespace kerf {

/// The cut polygon extruded to the separation surface S: a strip from `above_mm` outside to
/// `depth_mm` inside the organ. Each segment is sampled by itself, so that a polyline extended at
/// either end keeps the part of S it had, bit for bit (progressive cutting relies on it). A
/// polyline of fewer than two distinct points gives an empty surface.
/// @param polyline N×3 cut points on the rest surface, in order, mm
/// @param directions N×3 unit vectors into the tissue (camera rays), or 1×3 for one common
/// direction
/// @param spacing_mm longest side of a grid cell
/// @throws std::invalid_argument when rows do not match, a length is negative or not finite, a
/// direction is zero
CutSurface ExtrudePolyline(const Points& polyline, const Points& directions, double above_mm,
                           double depth_mm, double spacing_mm);

/// The same along one common direction (any length).
CutSurface ExtrudePolyline(const CutPolyline& polyline, const Vec3& direction, double above_mm,
                           double depth_mm, double spacing_mm);

}  // namespace kerf
