#include <gtest/gtest.h>

#include "Session/RateMeter.h"

namespace kerf {
namespace {

using std::chrono::milliseconds;

RateMeter::Clock::time_point At(int ms) {
  return RateMeter::Clock::time_point() + milliseconds(ms);
}

RateMeter Every(int period_ms, int count) {
  RateMeter meter;
  for (int i = 0; i < count; ++i) meter.Add(At(i * period_ms));
  return meter;
}

}  // namespace

TEST(RateMeter, FiveASecondAreFive) {
  EXPECT_NEAR(Every(200, 40).PerSecond(At(39 * 200)), 5.0, 1e-9);
  EXPECT_NEAR(Every(40, 100).PerSecond(At(99 * 40 + 10)), 25.0, 1e-9);
}

TEST(RateMeter, LessThanOneASecondIsTold) {
  EXPECT_NEAR(Every(2500, 4).PerSecond(At(3 * 2500)), 0.4, 1e-9);
}

TEST(RateMeter, FollowsAChangeWithinASecond) {
  RateMeter meter = Every(40, 50);
  for (int i = 1; i <= 5; ++i) meter.Add(At(49 * 40 + i * 250));
  EXPECT_NEAR(meter.PerSecond(At(49 * 40 + 5 * 250)), 4.0, 0.1);
}

TEST(RateMeter, ASilenceCounts) {
  const RateMeter meter = Every(40, 50);
  EXPECT_NEAR(meter.PerSecond(At(49 * 40 + 4000)), 0.25, 1e-9);
  EXPECT_EQ(RateMeter().PerSecond(At(0)), 0.0);
  EXPECT_EQ(Every(40, 1).PerSecond(At(0)), 0.0);
}

}  // namespace kerf
