#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "Core/Frame.h"

namespace kerf::testing {

/// Mean structural similarity (Wang 2004) of the luminance of two BGR pictures of one size, windows
/// of 8×8 pixels every 4 pixels: 1 for equal pictures, insensitive to a shade more or less,
/// sensitive to edges that moved.
inline double StructuralSimilarity(const Image& a, const Image& b) {
  if (a.width != b.width || a.height != b.height || a.channels != b.channels) return 0.0;
  const auto luminance = [](const Image& image, int x, int y) {
    const std::uint8_t* p = image.data.data() + (std::size_t(y) * image.width + x) * image.channels;
    return image.channels == 1 ? double(p[0]) : 0.114 * p[0] + 0.587 * p[1] + 0.299 * p[2];
  };
  constexpr int kWindow = 8, kStep = 4;
  constexpr double kC1 = 6.5025, kC2 = 58.5225;  // (0.01·255)², (0.03·255)²
  double sum = 0;
  int count = 0;
  for (int y = 0; y + kWindow <= a.height; y += kStep)
    for (int x = 0; x + kWindow <= a.width; x += kStep) {
      double ma = 0, mb = 0, aa = 0, bb = 0, ab = 0;
      for (int v = 0; v < kWindow; ++v)
        for (int u = 0; u < kWindow; ++u) {
          const double p = luminance(a, x + u, y + v), q = luminance(b, x + u, y + v);
          ma += p;
          mb += q;
          aa += p * p;
          bb += q * q;
          ab += p * q;
        }
      constexpr double n = kWindow * kWindow;
      ma /= n;
      mb /= n;
      const double va = aa / n - ma * ma, vb = bb / n - mb * mb, cov = ab / n - ma * mb;
      sum += (2 * ma * mb + kC1) * (2 * cov + kC2) / ((ma * ma + mb * mb + kC1) * (va + vb + kC2));
      ++count;
    }
  return count > 0 ? sum / count : 1.0;
}

}  // namespace kerf::testing
