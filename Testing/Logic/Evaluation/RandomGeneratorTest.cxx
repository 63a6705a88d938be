#include <gtest/gtest.h>

#include "Evaluation/RandomGenerator.h"

namespace kerf {
namespace {

/// numpy.random.default_rng(seed).bit_generator.random_raw(3) and .random()
TEST(RandomGenerator, DrawsWhatNumPyDraws) {
  RandomGenerator zero(0);
  EXPECT_EQ(zero.Next(), 0xa30febcfd9c2825fu);
  EXPECT_EQ(zero.Next(), 0x4510bdf882d9d721u);
  EXPECT_EQ(zero.Next(), 0x0a7d3da94ecde8b8u);
  RandomGenerator five(5);
  EXPECT_EQ(five.Next(), 0xce14abeeabb8e5a8u);
  RandomGenerator large(4294967295u);
  EXPECT_DOUBLE_EQ(large.Uniform(), 0.2519435680449965);
}

}  // namespace
}  // namespace kerf
