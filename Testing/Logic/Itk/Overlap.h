#pragma once

#include <cstdint>
#include <vector>

namespace kerf::testing {

/// Dice of two label maps' voxels that two predicates choose; 0 where neither has any.
template <class A, class B>
double Dice(const std::vector<std::uint8_t>& a, const std::vector<std::uint8_t>& b, A in_a,
            B in_b) {
  double both = 0, sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const bool x = in_a(a[i]), y = in_b(b[i]);
    both += x && y;
    sum += int(x) + int(y);
  }
  return sum > 0 ? 2 * both / sum : 0;
}

/// Of everything that has a label.
inline double OrganDice(const std::vector<std::uint8_t>& a, const std::vector<std::uint8_t>& b) {
  const auto any = [](int v) { return v > 0; };
  return Dice(a, b, any, any);
}

inline double LabelDice(const std::vector<std::uint8_t>& a, const std::vector<std::uint8_t>& b,
                        int n) {
  const auto is = [n](int v) { return v == n; };
  return Dice(a, b, is, is);
}

}  // namespace kerf::testing
