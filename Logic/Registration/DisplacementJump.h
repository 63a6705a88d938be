#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "Core/Types.h"

namespace kerf {

/// Neighbourhood of the features at rest, seen from the camera: who is beside whom, and which edges
/// can bear witness. Lateral coordinates: camera x, y in mm at rest (what a single camera
/// measures).
struct FeatureTriangulation {
  Pixels rest;  ///< N×2, lateral, mm
  std::vector<std::array<Index, 2>>
      edges;  ///< neighbours (l < m) that are not too far apart and not on too steep surface
  Eigen::VectorXd length_mm;           ///< of the edges
  std::vector<std::uint64_t> between;  ///< per pair: which of `near[l]` lie inside the circle over
                                       ///< it, bit k for near[l][k]
  std::vector<std::vector<Index>> near;  ///< up to 40 nearest features of each, in order
  /// A triangle at a feature, by its other corners a and b.
  struct FanTriangle {
    Index a = -1, b = -1;
    Eigen::Matrix2d from_sides;  ///< inverse of (a − feature, b − feature), 1/mm
  };
  std::vector<std::vector<FanTriangle>> fans;  ///< per feature, without slivers
  double spacing_mm = 0.0;                     ///< median edge length

  bool Empty() const { return edges.empty(); }
};

/// @param rest_camera N×3 features at rest in camera coordinates, mm
/// @param usable N flags; others are left out. Edges on surface steeper than `steepest` (depth per
/// lateral mm: the organ's rim, where neighbours in the image are no neighbours on the organ) bear
/// no witness.
FeatureTriangulation TriangulateFeatures(const Points& rest_camera, const std::vector<char>& usable,
                                         double steepest = 1.7);

/// Jump of the displacement across each edge: what is left of the relative displacement of its two
/// features after each side's own smooth deformation (a robust local affine fit, which follows the
/// feature's own side of a cut) is taken away. A stretch, a rotation, a bend give 0; a cut gives
/// its opening. A monocular analogue of the second observation of the paper ("increases much more
/// than the average") that needs no model in between.
struct DisplacementJumps {
  Pixels displacement_mm;                 ///< N×2, lateral, of the features since rest
  std::vector<Eigen::Matrix2d> gradient;  ///< N, of the displacement, on each feature's own side
  Eigen::VectorXd magnitude_mm;           ///< E, −1 where a feature is unusable
  std::vector<char> witness;  ///< E, hardly any seen feature lies between the two: they are next to
                              ///< each other now
  double noise_mm = 0.0;      ///< robust σ of all magnitudes
  double motion_mm = 0.0;     ///< robust scale of the smooth relative displacement of neighbours

  /// Relative displacement over edge e that is smooth deformation, mm.
  Vec2 Smooth_mm(const FeatureTriangulation& t, Index e) const {
    const auto [l, m] = t.edges[e];
    const Vec2 dx = (t.rest.row(m) - t.rest.row(l)).transpose();
    return 0.5 * (gradient[l] + gradient[m]) * dx;
  }
  /// What is left of it; both features must be usable.
  Vec2 Jump_mm(const FeatureTriangulation& t, Index e) const {
    const auto [l, m] = t.edges[e];
    return (displacement_mm.row(m) - displacement_mm.row(l)).transpose() - Smooth_mm(t, e);
  }
};

/// @param current N×2 lateral positions now, mm (pixels back-projected to the rest depth)
DisplacementJumps MeasureJumps(const FeatureTriangulation& triangulation, const Pixels& current,
                               const std::vector<char>& usable);

}  // namespace kerf
