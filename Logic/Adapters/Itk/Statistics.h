#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

namespace kerf {

/// Value below which `fraction` of the values lie. @param values not empty
inline double Quantile(std::vector<float> values, double fraction) {
  const auto at = values.begin() + std::ptrdiff_t(fraction * double(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

inline double Median(std::vector<float> values) { return Quantile(std::move(values), 0.5); }

/// Standard deviation by the median of absolute deviations: outliers do not count.
inline double Spread(const std::vector<float>& values, double median) {
  std::vector<float> deviations;
  deviations.reserve(values.size());
  for (const float v : values) deviations.push_back(float(std::abs(v - median)));
  return 1.4826 * Median(std::move(deviations));
}

}  // namespace kerf
