#include "Evaluation/FeatureError.h"

#include <algorithm>

namespace kerf {

std::optional<FeatureErrors> CompareFeatures(const Points& model, const Points& truth,
                                             const Vec3& eye) {
  FeatureErrors errors;
  for (Index i = 0; i < model.rows(); ++i) {
    const Vec3 x = model.row(i).transpose(), y = truth.row(i).transpose();
    if (!x.allFinite() || !y.allFinite()) continue;
    const Vec3 difference = x - y, sight = (y - eye).normalized();
    const double distance = difference.norm();
    const double lateral = (difference - difference.dot(sight) * sight).norm();
    errors.mean_mm += distance;
    errors.max_mm = std::max(errors.max_mm, distance);
    errors.lateral_mean_mm += lateral;
    errors.lateral_max_mm = std::max(errors.lateral_max_mm, lateral);
    ++errors.count;
  }
  if (errors.count == 0) return std::nullopt;
  errors.mean_mm /= errors.count;
  errors.lateral_mean_mm /= errors.count;
  return errors;
}

}  // namespace kerf
