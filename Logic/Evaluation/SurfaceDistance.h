#pragma once

#include <cstdint>
#include <optional>

#include "Core/SurfaceMesh.h"
#include "Evaluation/RandomGenerator.h"

namespace kerf {

/// Mean and largest of a set of distances, mm.
struct DistanceStatistics {
  double mean_mm = 0.0, max_mm = 0.0;
};

/// N×3 points spread evenly over the area of the surface.
Points SampleSurface(const SurfaceMesh& surface, int samples, RandomGenerator* random);

/// Two-sided sampled Hausdorff distance (the paper's): `samples` points on each surface, distance
/// of each to the other surface; mean over all of them, and the largest. None where a surface is
/// empty. Deterministic.
std::optional<DistanceStatistics> SampledHausdorff(const SurfaceMesh& a, const SurfaceMesh& b,
                                                   int samples, std::uint32_t seed = 0);

/// Where a surface that moved from `rest` to `current` (same triangles) carries rest points:
/// barycentric at the closest rest point, plus the offset from it. @param points N×3 at rest;
/// @return N×3, mm
Points CarriedPoints(const SurfaceMesh& rest, const Points& current, const Points& points);

}  // namespace kerf
