#pragma once

#include <array>
#include <cstdint>

namespace kerf {

/// PCG-64 (XSL-RR, O'Neill 2014), seeded as NumPy's default_rng(seed): whoever checks our figures
/// with NumPy draws the same samples. Deterministic on every platform.
class RandomGenerator {
 public:
  explicit RandomGenerator(std::uint32_t seed);
  std::uint64_t Next();
  /// Uniform in [0, 1), 53 bits.
  double Uniform() { return static_cast<double>(Next() >> 11) * (1.0 / 9007199254740992.0); }

 private:
  __extension__ using Wide = unsigned __int128;
  Wide state_ = 0, increment_ = 0;
};

}  // namespace kerf
