#pragma once

#include <cmath>
#include <random>
#include <vector>

#include "Core/Types.h"

/// A flat patch of features and a cut through it, for the tests of detection.
namespace kerf {

inline constexpr int kNx = 20, kNy = 9;
inline constexpr double kSpacing_mm = 4.5;

/// Features on a jittered grid, camera coordinates at 150 mm.
inline Points Scene() {
  std::mt19937 rng(3);
  std::uniform_real_distribution<double> jitter(-1.2, 1.2);
  Points p(kNx * kNy, 3);
  for (int j = 0; j < kNy; ++j)
    for (int i = 0; i < kNx; ++i) {
      p(j * kNx + i, 0) = kSpacing_mm * i + jitter(rng);
      p(j * kNx + i, 1) = kSpacing_mm * j + jitter(rng);
      p(j * kNx + i, 2) = 150.0;
    }
  return p;
}

inline std::vector<char> Everyone() { return std::vector<char>(kNx * kNy, 1); }

inline constexpr double kCut_mm = 38.2;  // between two columns of features

/// By how much x moves beside a crack along x = 38.2 from y = 0 to `tip`: ± √((r + b)/2) with r the
/// distance from the tip and b the distance behind it; smooth everywhere but on the cut.
inline double Opening(const Vec2& p, double tip, double amount) {
  const double behind = tip - p.y(), aside = p.x() - kCut_mm;
  const double root = std::sqrt(0.5 * (std::hypot(behind, aside) + behind));
  return (aside > 0.0 ? 1.0 : -1.0) * 1.1 * amount * std::exp(-std::abs(aside) / 40.0) * root;
}

/// A cut whose tip runs to y = 20 between progress 0.5 and 0.75, on top of a stretch.
inline Vec2 Cut(const Vec2& p, double progress) {
  Vec2 q(p.x() * (1.0 + 0.2 * progress), p.y());
  if (progress <= 0.5) return q;
  q.x() +=
      Opening(p, std::min(80.0 * (progress - 0.5), 20.0), std::min(1.0, 4.0 * (progress - 0.5)));
  return q;
}

}  // namespace kerf
