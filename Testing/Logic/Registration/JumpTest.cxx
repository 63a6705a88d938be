// Displacement jumps, evidence over time and the fitted line: what is a cut, and what only looks
// like one.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

#include "CutMotion.h"
#include "Registration/CutEvidence.h"
#include "Registration/CutLineFit.h"
#include "Support/Draws.h"

namespace kerf {
namespace {

using Motion = std::function<Vec2(const Vec2& rest, double progress)>;

struct Outcome {
  int first_frame = -1;
  std::vector<PartingEdge> parting;
  std::vector<Index> group;
  CutEvidence evidence;
  DisplacementJumps jumps;
};

/// Runs 100 frames of a motion (progress 0..1) with tracking noise; stops at the first group of
/// three.
Outcome Play(const Motion& motion, const std::vector<char>& usable, bool to_the_end = false) {
  const Points rest = Scene();
  std::mt19937 rng(11);
  std::normal_distribution<double> noise(0.0, 0.03);
  Outcome out;
  out.evidence = BeginEvidence(rest, std::vector<char>(rest.rows(), 1));
  for (int f = 0; f < 100; ++f) {
    Pixels current(rest.rows(), 2);
    for (Index i = 0; i < rest.rows(); ++i) {
      const Vec2 p = rest.row(i).head<2>().transpose();
      current.row(i) =
          (motion(p, f / 99.0) + testing::DrawVec2([&] { return noise(rng); })).transpose();
    }
    out.jumps = MeasureJumps(out.evidence.triangulation, current, usable);
    out.parting = UpdateEvidence(out.jumps, current, &out.evidence);
    const auto groups = GroupParting(out.parting, out.evidence.triangulation);
    if (!groups.empty() && groups[0].size() >= 3) {
      out.group = groups[0];
      if (out.first_frame < 0) out.first_frame = f;
      if (!to_the_end) break;
    }
  }
  return out;
}

TEST(Jumps, AffineMotionLeavesNone) {
  const Points rest = Scene();
  const auto triangulation = TriangulateFeatures(rest, Everyone());
  ASSERT_GT(triangulation.edges.size(), 400u);
  Eigen::Matrix2d a;
  a << 1.86, 0.1, -0.05, 0.8;
  const Pixels current = (rest.leftCols<2>() * a.transpose()).rowwise() + Eigen::RowVector2d(9, -4);
  const DisplacementJumps jumps = MeasureJumps(triangulation, current, Everyone());
  EXPECT_LT(jumps.magnitude_mm.maxCoeff(), 0.02);
}

TEST(Jumps, UnseenFeaturesGiveNoValue) {
  const Points rest = Scene();
  const auto triangulation = TriangulateFeatures(rest, Everyone());
  auto usable = Everyone();
  usable[50] = 0;
  const DisplacementJumps jumps = MeasureJumps(triangulation, rest.leftCols<2>(), usable);
  for (std::size_t e = 0; e < triangulation.edges.size(); ++e) {
    const bool has = triangulation.edges[e][0] == 50 || triangulation.edges[e][1] == 50;
    EXPECT_EQ(jumps.magnitude_mm[e] < 0.0, has);
  }
}

TEST(Jumps, TooFewFeaturesGiveAnEmptyTriangulation) {
  EXPECT_TRUE(TriangulateFeatures(Scene().topRows(5), std::vector<char>(5, 1)).Empty());
}

TEST(Evidence, ACutIsFoundSoonAfterItOpensAndWhereItIs) {
  const Outcome out = Play(Cut, Everyone());
  ASSERT_GE(out.first_frame, 50);
  EXPECT_LE(out.first_frame, 64);  // open by 1 mm at about frame 57
  const FittedLine line = FitCutLine(out.parting, out.group, out.evidence.triangulation, out.jumps);
  EXPECT_NEAR(line.At(0.0).x(), kCut_mm, 2.0);
  EXPECT_GT(std::abs(line.tangent.y()), 0.9);
}

TEST(Evidence, TheFittedLineFollowsTheWholeCut) {
  const Outcome out = Play(Cut, Everyone(), true);
  ASSERT_GE(out.group.size(), 6u);
  const FittedLine line = FitCutLine(out.parting, out.group, out.evidence.triangulation, out.jumps);
  for (double t = line.begin_mm; t <= line.end_mm; t += 1.0)
    EXPECT_NEAR(line.At(t).x(), kCut_mm, 2.0);
  const double reach = std::max(line.At(line.end_mm + line.end_tip_mm).y(),
                                line.At(line.begin_mm - line.begin_tip_mm).y());
  EXPECT_NEAR(reach, 20.0, 1.2 * kSpacing_mm);
}

// Negative twins: whatever is smooth, hidden or a single wrong track is no cut.
TEST(Evidence, StretchTo186PercentIsNoCut) {
  EXPECT_LT(Play([](const Vec2& p,
                    double s) { return Vec2(p.x() * (1 + 0.86 * s), p.y() * (1 - 0.2 * s)); },
                 Everyone())
                .first_frame,
            0);
}

TEST(Evidence, BendingAndTwistAreNoCut) {
  EXPECT_LT(Play(
                [](const Vec2& p, double s) {
                  const double k = 0.012 * s, angle = k * (p.x() - 45.0);
                  return Vec2(45.0 + std::sin(angle) / std::max(k, 1e-9) * (1 - k * p.y()),
                              p.y() + 20 * s * std::sin(p.x() / 30.0) + (1 - std::cos(angle)) * 20);
                },
                Everyone())
                .first_frame,
            0);
}

TEST(Evidence, AStrainConcentrationThatGrowsWithTheMotionIsNoCut) {
  EXPECT_LT(Play(
                [](const Vec2& p, double s) {
                  return Vec2(p.x() * (1 + 0.2 * s) + 4.0 * s * std::tanh((p.x() - 40.0) / 4.0),
                              p.y());
                },
                Everyone())
                .first_frame,
            0);
}

TEST(Evidence, OneWrongTrackIsNoCut) {
  const Points rest = Scene();
  const Vec2 wrong = rest.row(90).head<2>().transpose();
  EXPECT_LT(Play(
                [&](const Vec2& p, double s) {
                  return Vec2(
                      p.x() + ((p - wrong).norm() < 0.5 && s > 0.5 ? 25.0 * (s - 0.5) : 0.0),
                      p.y());
                },
                Everyone())
                .first_frame,
            0);
}

TEST(Evidence, ACutBehindAToolIsNotInvented) {
  // The features that the cut would part are hidden: no evidence, so no cut.
  const Points rest = Scene();
  auto usable = Everyone();
  for (Index i = 0; i < rest.rows(); ++i) usable[i] = rest(i, 0) < 20.0;
  EXPECT_LT(Play(Cut, usable).first_frame, 0);
}

}  // namespace
}  // namespace kerf
