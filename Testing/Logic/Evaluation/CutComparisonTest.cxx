#include <gtest/gtest.h>

#include "Evaluation/CutComparison.h"

namespace kerf {
namespace {

Points Line(const Vec3& a, const Vec3& b) {
  Points p(2, 3);
  p << a.transpose(), b.transpose();
  return p;
}

const TrueCut kTruth{80, 3.2, 84.0, Line({0, 0, 0}, {30, 0, 0})};

TEST(CutComparison, FindsTheCutAndItsErrors) {
  const auto c = CompareCuts({{90.0, Line({0, 2, 0}, {30, 2, 0})}}, {kTruth}, 25.0);
  ASSERT_EQ(c.matched.size(), 1u);
  EXPECT_EQ(c.missed, 0);
  EXPECT_EQ(c.false_cuts, 0);
  EXPECT_NEAR(c.matched[0].location.mean_mm, 2.0, 1e-9);
  EXPECT_NEAR(c.matched[0].location.hausdorff_mm, 2.0, 1e-9);
  EXPECT_NEAR(*c.matched[0].timing_error_s, 0.4, 1e-12);
  EXPECT_NEAR(*c.matched[0].delay_after_1mm_opening_s, 6 / 25.0, 1e-12);
}

TEST(CutComparison, AShortLineIsFarInOneDirectionOnly) {
  const LineDistance d = CompareLines(Line({0, 0, 0}, {10, 0, 0}), kTruth.polyline_rest);
  EXPECT_NEAR(d.detected_to_true_max_mm, 0.0, 1e-9);
  EXPECT_NEAR(d.true_to_detected_max_mm, 20.0, 1e-9);
  EXPECT_NEAR(d.detected_to_true_median_mm, 0.0, 1e-9);
}

TEST(CutComparison, FarEarlyAndDoubleCutsAreFalse) {
  const Points near = Line({0, 1, 0}, {30, 1, 0});
  const auto far = CompareCuts({{90.0, Line({0, 40, 0}, {30, 40, 0})}}, {kTruth}, 25.0);
  EXPECT_EQ(far.false_cuts, 1);
  EXPECT_EQ(far.missed, 1);
  EXPECT_EQ(CompareCuts({{74.0, near}}, {kTruth}, 25.0).false_cuts, 1) << "6 frames too early";
  EXPECT_EQ(CompareCuts({{75.0, near}}, {kTruth}, 25.0).false_cuts, 0) << "0.2 s are allowed";
  const auto twice = CompareCuts({{90.0, near}, {95.0, kTruth.polyline_rest}}, {kTruth}, 25.0);
  EXPECT_EQ(twice.false_cuts, 1);
  ASSERT_EQ(twice.matched.size(), 1u);
  EXPECT_EQ(twice.matched[0].detected, 1) << "the nearer line wins";
  EXPECT_EQ(CompareCuts({{90.0, near}}, {}, 25.0).false_cuts, 1) << "nothing was cut";
}

TEST(CutComparison, EachOfSeveralTrueCutsIsPairedWithItsOwn) {
  const TrueCut second{115, 4.6, 120.0, Line({0, 12, 0}, {30, 12, 0})};
  const std::vector<TrueCut> truth{kTruth, second};
  const DetectedCut of_first{90.0, Line({0, 1, 0}, {28, 1, 0})},
      of_second{130.0, Line({2, 10, 0}, {30, 10, 0})};
  // In whatever order they are told.
  for (const auto& found : {std::vector<DetectedCut>{of_first, of_second},
                            std::vector<DetectedCut>{of_second, of_first}}) {
    const auto c = CompareCuts(found, truth, 25.0);
    EXPECT_EQ(c.truth, 2);
    EXPECT_EQ(c.detected, 2);
    EXPECT_EQ(c.missed, 0);
    EXPECT_EQ(c.false_cuts, 0);
    ASSERT_EQ(c.matched.size(), 2u);
    for (const CutMatch& match : c.matched) {
      const bool first = match.truth == 0;
      EXPECT_EQ(found[match.detected].detected_frame, first ? 90.0 : 130.0);
      EXPECT_NEAR(*match.delay_after_1mm_opening_s, (first ? 6 : 10) / 25.0, 1e-12);
      EXPECT_NEAR(match.location.detected_to_true_median_mm, first ? 1.0 : 2.0, 1e-9);
    }
  }

  const auto one = CompareCuts({of_second}, truth, 25.0);
  ASSERT_EQ(one.matched.size(), 1u);
  EXPECT_EQ(one.matched[0].truth, 1);
  EXPECT_EQ(one.missed, 1) << "the first";
  EXPECT_EQ(one.false_cuts, 0);

  // A second find of the first cut, before the second cut begins, is false.
  const auto twice = CompareCuts({of_first, {100.0, Line({0, 2, 0}, {30, 2, 0})}}, truth, 25.0);
  ASSERT_EQ(twice.matched.size(), 1u);
  EXPECT_EQ(twice.matched[0].truth, 0);
  EXPECT_EQ(twice.missed, 1);
  EXPECT_EQ(twice.false_cuts, 1);

  // One find between the two counts for one of them only.
  const auto between = CompareCuts({{130.0, Line({0, 5, 0}, {30, 5, 0})}}, truth, 25.0);
  ASSERT_EQ(between.matched.size(), 1u);
  EXPECT_EQ(between.matched[0].truth, 0);
  EXPECT_EQ(between.missed, 1);
}

TEST(CutComparison, ACutWithoutALineOrAFrame) {
  EXPECT_EQ(CompareCuts({{90.0, Points(0, 3)}}, {kTruth}, 25.0).missed, 1);
  const auto c = CompareCuts({{std::nullopt, kTruth.polyline_rest}}, {kTruth}, 25.0);
  ASSERT_EQ(c.matched.size(), 1u);
  EXPECT_FALSE(c.matched[0].timing_error_s.has_value());
}

}  // namespace
}  // namespace kerf
