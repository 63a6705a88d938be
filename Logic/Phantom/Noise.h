#pragma once

#include <cmath>
#include <cstdint>

#include "Core/Types.h"

/// Counter-based noise: every value is a function of its coordinates and the seed, so that the
/// order of evaluation and the number of threads do not matter.
namespace kerf {

inline std::uint32_t HashMix(std::uint32_t x) {
  x ^= x >> 16;
  x *= 0x7feb352dU;
  x ^= x >> 15;
  x *= 0x846ca68bU;
  return x ^ (x >> 16);
}
inline std::uint32_t Hash(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t seed) {
  return HashMix(a + HashMix(b + HashMix(c + HashMix(seed))));
}
/// Uniform in [0, 1).
inline double UniformFromHash(std::uint32_t h) { return (h >> 8) * (1.0 / 16777216.0); }
/// About normal (sum of four uniforms), zero mean, unit variance, within ±3.5.
inline double NormalFromHash(std::uint32_t h) {
  double sum = 0.0;
  for (int i = 0; i < 4; ++i) {
    h = HashMix(h + 0x9e3779b9U);
    sum += UniformFromHash(h);
  }
  return (sum - 2.0) * 1.7320508075688772;
}

/// Smooth value noise in −1..1 with features of about one unit.
inline double ValueNoise(const Vec3& p, std::uint32_t seed) {
  const double fx = std::floor(p.x()), fy = std::floor(p.y()), fz = std::floor(p.z());
  const auto i = static_cast<std::uint32_t>(static_cast<std::int32_t>(fx));
  const auto j = static_cast<std::uint32_t>(static_cast<std::int32_t>(fy));
  const auto k = static_cast<std::uint32_t>(static_cast<std::int32_t>(fz));
  auto fade = [](double t) { return t * t * t * (t * (6.0 * t - 15.0) + 10.0); };
  const double u = fade(p.x() - fx), v = fade(p.y() - fy), w = fade(p.z() - fz);
  // A cheap lattice hash: products with large odd numbers, one mix.
  auto corner = [&](std::uint32_t di, std::uint32_t dj, std::uint32_t dk) {
    const std::uint32_t h = HashMix((i + di) * 0x8da6b343U ^ (j + dj) * 0xd8163841U ^
                                    (k + dk) * 0xcb1ab31fU ^ seed * 0x9e3779b9U);
    return UniformFromHash(h) * 2.0 - 1.0;
  };
  auto mix = [](double a, double b, double t) { return a + t * (b - a); };
  const double x00 = mix(corner(0, 0, 0), corner(1, 0, 0), u),
               x10 = mix(corner(0, 1, 0), corner(1, 1, 0), u);
  const double x01 = mix(corner(0, 0, 1), corner(1, 0, 1), u),
               x11 = mix(corner(0, 1, 1), corner(1, 1, 1), u);
  return mix(mix(x00, x10, v), mix(x01, x11, v), w);
}

/// Octaves of value noise, each half as strong and twice as fine.
inline double FractalNoise(const Vec3& p, int octaves, std::uint32_t seed) {
  double sum = 0.0, weight = 0.5;
  Vec3 q = p;
  for (int i = 0; i < octaves; ++i, weight *= 0.5, q *= 2.03)
    sum += weight * ValueNoise(q, seed + 101U * i);
  return sum;
}

inline double SmoothRamp(double x, double low, double high) {
  const double t = x <= low ? 0.0 : x >= high ? 1.0 : (x - low) / (high - low);
  return t * t * (3.0 - 2.0 * t);
}

}  // namespace kerf
