#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "Core/Errors.h"
#include "Evaluation/Scores.h"

namespace kerf {
namespace {

Scores Example() {
  Scores s;
  s.frames = {{20, {{"dice", 0.9}, {"organ_max", 8.0}}, 0},
              {25, {{"dice", 0.95}, {"organ_max", 5.0}, {"feature_mean", 1.5}}, 10}};
  s.cuts.missed = 1;
  Summarize(&s);
  return s;
}

TEST(Scores, WorstIsTheSmallestDiceAndTheLargestDistance) {
  const Scores s = Example();
  EXPECT_EQ(s.final_values.at("dice"), 0.95);
  EXPECT_EQ(s.over_frames.at("dice").worst, 0.9);
  EXPECT_EQ(s.over_frames.at("organ_max").worst, 8.0);
  EXPECT_NEAR(s.over_frames.at("organ_max").mean, 6.5, 1e-12);
  EXPECT_EQ(s.over_frames.at("feature_mean").mean, 1.5) << "only frames that have it count";
}

TEST(Scores, Requirements) {
  const Scores s = Example();
  auto unmet = [&](const char* text) {
    return UnmetRequirements(s, ParseRequirements(text)).size();
  };
  EXPECT_EQ(unmet("dice=0.95"), 0u);
  EXPECT_EQ(unmet("dice=0.96"), 1u);
  EXPECT_EQ(unmet("dice=0.9,feature_mean=1.5,organ_max=5"), 0u);
  EXPECT_EQ(unmet("feature_mean=1.4,organ_max=4"), 2u);
  EXPECT_EQ(unmet("missed=0"), 1u);
  EXPECT_EQ(unmet("false=0,missed=1"), 0u);
  EXPECT_EQ(unmet("internal_mean=100"), 1u) << "what could not be measured is not met";
}

TEST(Scores, BadRequirementsAreWrongUse) {
  for (const char* text : {"", "dice", "dice=", "dice=x", "dice=0.9x", "size=3", "dice=nan"})
    EXPECT_THROW(ParseRequirements(text), UsageError) << text;
}

}  // namespace
}  // namespace kerf
