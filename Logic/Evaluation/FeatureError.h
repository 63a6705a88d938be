#pragma once

#include <optional>

#include "Core/Types.h"

namespace kerf {

/// Feature error: distance of points on the model from their true positions, in 3-D and its part
/// across the line of sight (what the paper's distance to its own targets can see), mm.
struct FeatureErrors {
  double mean_mm = 0.0, max_mm = 0.0;
  double lateral_mean_mm = 0.0, lateral_max_mm = 0.0;
  int count = 0;
};

/// @param model, truth N×3, same rows; rows with a value that is not a number are left out
/// @param eye camera centre. None where no row is left.
std::optional<FeatureErrors> CompareFeatures(const Points& model, const Points& truth,
                                             const Vec3& eye);

}  // namespace kerf
