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
  double last_frame_ = setup_.frame_count - 1;

  /// From rest over every stage of every cut to the end.
  std::vector<double> Stages() const {
    std::vector<double> frames{40.0, 72.0};
    for (const auto& cut : setup_.motion.cuts)
      for (double share : {0.2, 0.5, 0.75, 1.0})
        frames.push_back(cut.start_frame + share * (cut.end_frame - cut.start_frame));
    frames.push_back(last_frame_);
    return frames;
  }
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

  bool OnSheet(const Vec3& p, double tolerance_mm) const {
    for (int cut = 0; cut < motion_.CutCount(); ++cut)
      if (std::abs(motion_.SheetDistance_mm(p, cut)) < tolerance_mm) return true;
    return false;
  }
};

TEST_P(EveryScenario, IsExactlyAtRestInTheFirstSecond) {
  for (const Vec3& p : Samples(200))
    for (int frame = 0; frame <= setup_.rest_frames; ++frame)
      EXPECT_EQ(motion_.Position(p, 1, frame), p);
}

TEST_P(EveryScenario, NeverFolds) {
  double largest = 0.0;
  for (double frame : Stages())
    for (const Vec3& p : Samples(4000)) {
      const double h = 0.004;
      if (OnSheet(p, 4.0 * h)) continue;  // both lips in one difference
      const int region = motion_.Region(p);
      Mat3 gradient;
      for (int k = 0; k < 3; ++k) {
        const Vec3 step = h * Vec3::Unit(k);
        gradient.col(k) = (motion_.Position(p + step, region, frame) -
                           motion_.Position(p - step, region, frame)) /
                          (2.0 * h);
      }
      const double j = gradient.determinant();
      ASSERT_GT(j, 0.5) << "frame " << frame << ", " << p.transpose();
      largest = std::max(largest, j);
    }
  EXPECT_LT(largest, 9.0) << "only the tip of the cut may strain that much";
}

TEST_P(EveryScenario, KeepsItsVolumeWithinFivePercent) {
  const PhantomAnatomy anatomy = BuildPhantomAnatomy(setup_);
  auto volume = [&](double frame) {
    // Opened faces close the surface; closed ones coincide and add nothing.
    return OrganAtFrame(anatomy, motion_, frame).mesh.SignedVolume();
  };
  const double rest = volume(0);
  for (double frame : Stages()) EXPECT_NEAR(volume(frame) / rest, 1.0, 0.05) << frame;
}

/// Also while the other cut grows: each has its own time and tip.
TEST_P(EveryScenario, LipsOpenBehindTheTipAndNowhereElse) {
  for (int cut = 0; cut < motion_.CutCount(); ++cut) {
    const PhantomCutParameters& c = setup_.motion.cuts[cut];
    EXPECT_EQ(motion_.TipDepth_mm(c.start_frame, cut), 0.0);
    EXPECT_DOUBLE_EQ(motion_.TipDepth_mm(last_frame_, cut), c.final_depth_mm);
    for (double frame : Stages()) {
      const double tip = motion_.TipDepth_mm(frame, cut);
      for (double depth = 0.25; depth < 34.0; depth += 0.5) {
        const double y = c.entry_y_mm + c.into * depth;
        const Vec3 p(motion_.SheetX_mm(y, cut), y, 1.0);
        const Vec3 minus = motion_.Position(p, cut, frame),
                   plus = motion_.Position(p, cut + 1, frame);
        const Vec3 gap = plus - minus;
        if (depth < tip)
          EXPECT_GT(gap.x(), 0.0) << "the lips must not pass through each other";
        else
          EXPECT_LT(gap.norm(), 1e-9) << "ahead of the tip the body is whole, depth " << depth;
        EXPECT_NEAR(gap.x(), motion_.Opening_mm(depth, frame, cut), 1e-9);
      }
    }
  }
}

TEST_P(EveryScenario, IsContinuousAheadOfTheTip) {
  for (int cut = 0; cut < motion_.CutCount(); ++cut)
    for (double frame : Stages()) {
      const PhantomCutParameters& c = setup_.motion.cuts[cut];
      const double y = c.entry_y_mm + c.into * (motion_.TipDepth_mm(frame, cut) + 2.0);
      const double x = motion_.SheetX_mm(y, cut);
      const Vec3 gap = motion_.Position({x + 1e-4, y, 0}, cut + 1, frame) -
                       motion_.Position({x - 1e-4, y, 0}, cut, frame);
      EXPECT_LT(gap.norm(), 2e-3);
    }
}

TEST_P(EveryScenario, MovesSmoothlyFromFrameToFrame) {
  for (const Vec3& p : Samples(300))
    for (int frame = 0; frame + 1 < setup_.frame_count; ++frame) {
      const int region = motion_.Region(p);
      ASSERT_LT(
          (motion_.Position(p, region, frame + 1) - motion_.Position(p, region, frame)).norm(), 2.5)
          << "frame " << frame << ", " << p.transpose();
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
    EXPECT_EQ(motion.TipDepth_mm(76, 0), 0.0);
    for (int frame = 77; frame < 118; ++frame)
      EXPECT_GT(motion.TipDepth_mm(frame + 1, 0), motion.TipDepth_mm(frame, 0));
    EXPECT_GT(motion.Opening_mm(0.0, 149, 0), 14.0);
    EXPECT_LT(motion.Opening_mm(0.0, 149, 0), 23.0);
  }
}

TEST(PhantomMotion, TheSecondCutComesASecondAndMoreAfterTheFirstAndWellAway) {
  for (auto scenario : {PhantomScenario::KidneyTwoCuts, PhantomScenario::BandTwoCuts}) {
    const PhantomSetup setup = MakePhantomSetup(scenario, 1);
    const PhantomMotion motion(setup.motion);
    ASSERT_EQ(motion.CutCount(), 2);
    const auto& first = setup.motion.cuts[0];
    const auto& second = setup.motion.cuts[1];
    EXPECT_GT(second.start_frame - first.start_frame, setup.frames_per_second);
    EXPECT_GT(second.start_frame, first.end_frame) << "one after the other";
    EXPECT_GT(second.sheet_x_mm - first.sheet_x_mm, 30.0);
    EXPECT_GT(motion.Opening_mm(0.0, second.start_frame, 0), 3.0) << "the first is seen by then";
    EXPECT_EQ(motion.Opening_mm(0.0, second.start_frame, 1), 0.0);
    for (int cut = 0; cut < 2; ++cut) {
      EXPECT_GT(motion.Opening_mm(0.0, setup.frame_count - 1, cut), 10.0);
      EXPECT_LT(motion.Opening_mm(0.0, setup.frame_count - 1, cut), 20.0);
      const Points line = CutLine(setup, motion, cut, setup.motion.cuts[cut].final_depth_mm);
      EXPECT_EQ(motion.Depth_mm(line.row(line.rows() - 1), cut),
                setup.motion.cuts[cut].final_depth_mm);
      EXPECT_EQ(motion.Region(Vec3(line.row(3)) - Vec3(0.1, 0, 0)), cut);
      EXPECT_EQ(motion.Region(Vec3(line.row(3)) + Vec3(0.1, 0, 0)), cut + 1);
    }
  }
  const auto band = MakePhantomSetup(PhantomScenario::BandTwoCuts, 1).motion.cuts;
  EXPECT_EQ(band[0].entry_y_mm, -band[1].entry_y_mm) << "from opposite edges";
}

TEST(PhantomMotion, ACompleteCutPartsTheBodyFromEdgeToEdge) {
  for (auto scenario : {PhantomScenario::KidneyThrough, PhantomScenario::BandThrough}) {
    const PhantomSetup setup = MakePhantomSetup(scenario, 1);
    const PhantomMotion motion(setup.motion);
    const Points line = CutLine(setup, motion, 0, setup.motion.cuts[0].final_depth_mm);
    const double far = motion.Depth_mm(line.row(line.rows() - 1), 0);
    EXPECT_LT(far, setup.motion.cuts[0].final_depth_mm) << "the line ends where the body does";
    EXPECT_GT(far, 29.0);
    EXPECT_GT(motion.Opening_mm(far, 149, 0), 5.0);
    const PhantomAnatomy anatomy = BuildPhantomAnatomy(setup);
    const PhantomSurfaceAtFrame organ = OrganAtFrame(anatomy, motion, 149);
    double left = -1e9, right = 1e9;  // the pieces, along the pull
    for (std::size_t p = 0; p < organ.pid.size(); ++p) {
      const Vec3 rest = anatomy.organ.points.row(organ.pid[p]);
      const double from_sheet = organ.mesh.points(p, 0) - motion.SheetX_mm(rest.y(), 0);
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
  const Points line =
      CutLine(setup, PhantomMotion(setup.motion), 0, setup.motion.cuts[0].final_depth_mm);
  EXPECT_NEAR(line(line.rows() - 1, 0) - line(0, 0), 13.5, 0.5);
}

TEST(PhantomMotion, NegativesHaveNoCut) {
  for (auto scenario : {PhantomScenario::KidneyNoCut, PhantomScenario::BandStretch}) {
    const PhantomMotion motion(MakePhantomSetup(scenario, 1).motion);
    EXPECT_EQ(motion.CutCount(), 0);
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
