#include "Evaluation/RandomGenerator.h"

namespace kerf {
namespace {

__extension__ using Wide = unsigned __int128;

constexpr Wide kMultiplier = (Wide(2549297995355413924ULL) << 64) | 4865540595714422341ULL;

/// One scrambling step of NumPy's SeedSequence; the constant evolves with every use.
std::uint32_t Scramble(std::uint32_t value, std::uint32_t* constant, std::uint32_t multiplier) {
  value ^= *constant;
  *constant *= multiplier;
  value *= *constant;
  return value ^ (value >> 16);
}

std::uint32_t Mix(std::uint32_t x, std::uint32_t y) {
  const std::uint32_t mixed = 0xca01f9ddu * x - 0x4973f715u * y;
  return mixed ^ (mixed >> 16);
}

/// Four 64-bit words from one seed (SeedSequence(seed).generate_state(4, uint64)).
std::array<std::uint64_t, 4> SeedWords(std::uint32_t seed) {
  std::array<std::uint32_t, 4> pool;
  std::uint32_t constant = 0x43b0d7e5u;
  for (int i = 0; i < 4; ++i) pool[i] = Scramble(i == 0 ? seed : 0, &constant, 0x931e8875u);
  for (int source = 0; source < 4; ++source)
    for (int target = 0; target < 4; ++target)
      if (source != target)
        pool[target] = Mix(pool[target], Scramble(pool[source], &constant, 0x931e8875u));
  constant = 0x8b51f9ddu;
  std::array<std::uint64_t, 4> words;
  for (int i = 0; i < 8; ++i) {
    const std::uint64_t half = Scramble(pool[i % 4], &constant, 0x58f38dedu);
    if (i % 2 == 0)
      words[i / 2] = half;
    else
      words[i / 2] |= half << 32;
  }
  return words;
}

}  // namespace

RandomGenerator::RandomGenerator(std::uint32_t seed) {
  const auto words = SeedWords(seed);
  increment_ = (((Wide(words[2]) << 64) | words[3]) << 1) | 1;
  state_ = increment_ + ((Wide(words[0]) << 64) | words[1]);
  state_ = state_ * kMultiplier + increment_;
}

std::uint64_t RandomGenerator::Next() {
  state_ = state_ * kMultiplier + increment_;
  const auto folded = static_cast<std::uint64_t>(state_ >> 64) ^ static_cast<std::uint64_t>(state_);
  const auto rotation = static_cast<unsigned>(state_ >> 122);
  return (folded >> rotation) | (folded << ((64 - rotation) & 63));
}

}  // namespace kerf
