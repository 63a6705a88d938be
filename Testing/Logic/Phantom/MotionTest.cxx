#include <gtest/gtest.h>

#include <random>

#include "Core/Errors.h"
#include "Phantom/PhantomAnatomy.h"
#include "Phantom/PhantomShape.h"
#include "Support/Draws.h"

namespace kerf {
namespace {

class EveryScenario : public ::testing::TestWithParam<PhantomScenario> {
 protected:
  PhantomSetup setup_ = MakePhantomSetup(GetParam(), 1);
  PhantomMotion motion_{setup_.motion};

  /// Random points of the body at rest, the same on every run.
  std::vector<Vec3> Samples(int count) const {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    std::vector<Vec3> points;
    while (static_cast<int>(points.size()) < count) {
      const Vec3 box = setup_.is_kidney ? Vec3(55, 34, 28) : Vec3(0.5 * setup_.band_size_mm);
      const Vec3 p = testing::DrawVec3([&] { return unit(random); }).cwiseProduct(box);
      if (!setup_.is_kidney || KidneyOrgan(p) < 0.0) points.push_back(p);
    }
    return points;
  }
};

TEST_P(EveryScenario, IsExactlyAtRestInTheFirstSecond) {
  for (const Vec3& p : Samples(200))
    for (int frame = 0; frame <= setup_.rest_frames; ++frame)
      EXPECT_EQ(motion_.Position(p, 1, frame), p);
}

TEST_P(EveryScenario, NeverFolds) {
  double largest = 0.0;
  for (double frame : {40.0, 72.0, 84.0, 95.0, 107.0, 118.0, 149.0})
    for (const Vec3& p : Samples(4000)) {
      const double s = motion_.SheetDistance_mm(p), h = 0.004;
      if (setup_.motion.has_cut && std::abs(s) < 4.0 * h) continue;  // both lips in one difference
      const int side = s < 0.0 ? -1 : 1;
      Mat3 gradient;
      for (int k = 0; k < 3; ++k) {
        const Vec3 step = h * Vec3::Unit(k);
        gradient.col(k) =
            (motion_.Position(p + step, side, frame) - motion_.Position(p - step, side, frame)) /
            (2.0 * h);
      }
      const double j = gradient.determinant();
      ASSERT_GT(j, 0.5) << "frame " << frame << ", " << p.transpose();
      largest = std::max(largest, j);
    }
  EXPECT_LT(largest, 8.0) << "only the tip of the cut may strain that much";
}

TEST_P(EveryScenario, KeepsItsVolumeWithinFivePercent) {
  const PhantomAnatomy anatomy = BuildPhantomAnatomy(setup_);
  auto volume = [&](double frame) {
    // Opened faces close the surface; closed ones coincide and add nothing.
    return OrganAtFrame(anatomy, motion_, frame).mesh.SignedVolume();
  };
  const double rest = volume(0);
  for (double frame : {60.0, 90.0, 118.0, 149.0})
    EXPECT_NEAR(volume(frame) / rest, 1.0, 0.05) << frame;
}

TEST_P(EveryScenario, LipsOpenBehindTheTipAndNowhereElse) {
  for (double frame : {30.0, 76.0, 85.0, 100.0, 118.0, 149.0}) {
    const double tip = motion_.TipDepth_mm(frame);
    for (double depth = 0.25; depth < 34.0; depth += 0.5) {
      const double y = setup_.motion.entry_y_mm + depth;
      const Vec3 p(motion_.SheetX_mm(y), y, 1.0);
      const Vec3 minus = motion_.Position(p, -1, frame), plus = motion_.Position(p, 1, frame);
      const Vec3 gap = plus - minus;
      if (depth < tip)
        EXPECT_GT(gap.x(), 0.0) << "the lips must not pass through each other";
      else
        EXPECT_LT(gap.norm(), 1e-9) << "ahead of the tip the body is whole, depth " << depth;
      EXPECT_NEAR(gap.x(), motion_.Opening_mm(depth, frame), 1e-9);
    }
  }
}

TEST_P(EveryScenario, IsContinuousAheadOfTheTip) {
  for (double frame : {85.0, 100.0, 149.0}) {
    const double y = setup_.motion.entry_y_mm + motion_.TipDepth_mm(frame) + 2.0;
    const double x = motion_.SheetX_mm(y);
    const Vec3 gap = motion_.Position({x + 1e-4, y, 0}, 1, frame) -
                     motion_.Position({x - 1e-4, y, 0}, -1, frame);
    EXPECT_LT(gap.norm(), 2e-3);
  }
}

INSTANTIATE_TEST_SUITE_P(Phantom, EveryScenario, ::testing::ValuesIn(kPhantomScenarios),
                         [](const auto& info) {
                           std::string name = ToString(info.param);
                           name.erase(std::remove(name.begin(), name.end(), '-'), name.end());
                           return name;
                         });

TEST(PhantomMotion, TheCutGrowsAndOpensSoThatOneSeesIt) {
  for (auto scenario : {PhantomScenario::KidneyCut, PhantomScenario::BandCut}) {
    const PhantomSetup setup = MakePhantomSetup(scenario, 1);
    const PhantomMotion motion(setup.motion);
    EXPECT_EQ(motion.TipDepth_mm(76), 0.0);
    for (int frame = 77; frame < 118; ++frame)
      EXPECT_GT(motion.TipDepth_mm(frame + 1), motion.TipDepth_mm(frame));
    EXPECT_DOUBLE_EQ(motion.TipDepth_mm(149), setup.motion.final_depth_mm);
    EXPECT_GT(motion.Opening_mm(0.0, 149), 14.0);
    EXPECT_LT(motion.Opening_mm(0.0, 149), 23.0);
  }
}

TEST(PhantomMotion, ACompleteCutPartsTheBodyFromEdgeToEdge) {
  for (auto scenario : {PhantomScenario::KidneyThrough, PhantomScenario::BandThrough}) {
    const PhantomSetup setup = MakePhantomSetup(scenario, 1);
    const PhantomMotion motion(setup.motion);
    const Points line = CutLine(setup, motion, setup.motion.final_depth_mm);
    const double far = motion.Depth_mm(line.row(line.rows() - 1));
    EXPECT_LT(far, setup.motion.final_depth_mm) << "the line ends where the body does";
    EXPECT_GT(far, 29.0);
    EXPECT_GT(motion.Opening_mm(far, 149), 5.0);
    const PhantomAnatomy anatomy = BuildPhantomAnatomy(setup);
    const PhantomSurfaceAtFrame organ = OrganAtFrame(anatomy, motion, 149);
    double left = -1e9, right = 1e9;  // the pieces, along the pull
    for (std::size_t p = 0; p < organ.pid.size(); ++p) {
      const Vec3 rest = anatomy.organ.points.row(organ.pid[p]);
      const double from_sheet = organ.mesh.points(p, 0) - motion.SheetX_mm(rest.y());
      if (anatomy.organ_region[organ.pid[p]] == 0)
        left = std::max(left, from_sheet);
      else
        right = std::min(right, from_sheet);
    }
    EXPECT_GT(right - left, 4.0) << "nothing holds them together";
    for (Index i = 0; i < line.rows(); ++i)
      if (setup.is_kidney) {
        EXPECT_NEAR(KidneyOrgan(line.row(i)), 0.0, 0.05);
      }
  }
}

TEST(PhantomMotion, TheCurvedCutBends) {
  const PhantomSetup setup = MakePhantomSetup(PhantomScenario::KidneyCurved, 1);
  const Points line = CutLine(setup, PhantomMotion(setup.motion), setup.motion.final_depth_mm);
  EXPECT_NEAR(line(line.rows() - 1, 0) - line(0, 0), 13.5, 0.5);
}

TEST(PhantomMotion, NegativesHaveNoCut) {
  for (auto scenario : {PhantomScenario::KidneyNoCut, PhantomScenario::BandStretch}) {
    const PhantomMotion motion(MakePhantomSetup(scenario, 1).motion);
    for (int frame = 0; frame < 150; ++frame) EXPECT_EQ(motion.Opening_mm(0.0, frame), 0.0);
  }
}

TEST(PhantomMotion, BandStretchIsUniform) {
  const PhantomMotion motion(MakePhantomSetup(PhantomScenario::BandStretch, 1).motion);
  const Vec3 a = motion.Position({-40, 3, 1}, 1, 149), b = motion.Position({10, 3, 1}, 1, 149),
             c = motion.Position({60, 3, 1}, 1, 149);
  EXPECT_NEAR((b - a).x(), 85.0, 1e-6);
  EXPECT_NEAR((c - b).x(), 85.0, 1e-6);
}

TEST(PhantomScenario, NamesAreReadBack) {
  for (auto s : kPhantomScenarios) EXPECT_EQ(ParsePhantomScenario(ToString(s)), s);
  EXPECT_THROW(ParsePhantomScenario("spleen"), UsageError);
}

}  // namespace
}  // namespace kerf
