// From parting features to lines on the organ: where a cut begins, grows and ends.
#include <gtest/gtest.h>

#include <algorithm>

#include "CutMotion.h"
#include "Registration/CutLine.h"
#include "Registration/JumpDetection.h"
#include "Support/TestCameras.h"
#include "Support/TestMeshes.h"

namespace kerf {
namespace {

/// A slab under the features; the world is the camera.
class JumpDetection : public ::testing::Test {
 protected:
  JumpDetection() : camera(testing::Pinhole(640, 480, 700.0)) {
    state.mesh = testing::BoxMesh(Vec3(94.0, 44.0, 20.0), 12, 6, 3);
    const Eigen::RowVector3d low = state.mesh.rest.colwise().minCoeff();
    state.mesh.rest.rowwise() += Eigen::RowVector3d(-4.0, -4.0, 150.0) - low;
    state.positions = state.mesh.rest;
    state.uncut = std::make_shared<SurfaceTree>(BoundarySurface(state.mesh, state.mesh.rest));
    state.evidence = BeginEvidence(rest, Everyone());
  }
  /// Frames up to and without `last`. @return the events of all
  std::vector<CutEvent> Play(int last) {
    std::vector<CutEvent> events;
    for (; state.frame + 1 < last;) {
      ++state.frame;
      Pixels now(rest.rows(), 2);
      for (Index i = 0; i < rest.rows(); ++i)
        now.row(i) = Cut(rest.row(i).head<2>().transpose(), state.frame / 99.0).transpose();
      for (const CutEvent& event : DetectCutsByJumps(now, Everyone(), camera, options, &state))
        events.push_back(event);
    }
    return events;
  }
  /// Opens up to `tip` at once, after a second of rest. @return the number of events
  std::size_t OpenAtOnce(double tip, double amount, const std::vector<char>& usable = Everyone()) {
    state.evidence = BeginEvidence(rest, Everyone());
    std::size_t events = 0;
    for (state.frame = 0; state.frame < 40; ++state.frame) {
      Pixels now = rest.leftCols<2>();
      if (state.frame > 30)
        for (Index i = 0; i < rest.rows(); ++i)
          now(i, 0) += Opening(rest.row(i).head<2>().transpose(), tip, amount);
      events += DetectCutsByJumps(now, usable, camera, options, &state).size();
    }
    const auto& streak = state.evidence.streak;
    parting = std::count_if(streak.begin(), streak.end(), [](int frames) { return frames > 1; });
    return events;
  }
  /// A cut that is known already.
  void Know(const Vec3& from, const Vec3& to) {
    ModelCut cut;
    cut.line.points.resize(2, 3);
    cut.line.points << from.transpose(), to.transpose();
    state.cuts = {cut};
  }
  double LargestOffset_mm(const Points& line) const {
    return (line.col(0).array() - kCut_mm).abs().maxCoeff();
  }
  /// Number of the row of the deepest tip, where the cut ends inside the slab.
  Index Tip(const Points& line) const {
    return line(0, 1) > line(line.rows() - 1, 1) ? 0 : line.rows() - 1;
  }

  static constexpr double kLittle = 0.22;  // of the opening of `Cut`
  const Points rest = Scene();
  std::ptrdiff_t parting = 0;  ///< pairs that part, of the last play
  CameraModel camera;
  MethodOptions options;
  RegistrationState state;
};

TEST_F(JumpDetection, ACutBeginsGrowsAndGoesOverTheRim) {
  const auto events = Play(100);
  ASSERT_EQ(state.cuts.size(), 1u);
  ASSERT_GE(events.size(), 2u);
  EXPECT_TRUE(events.front().first);
  EXPECT_FALSE(events.back().first);
  const Points& line = state.cuts[0].line.points;
  EXPECT_LT(LargestOffset_mm(line), 2.0);
  EXPECT_LT(line.col(1).minCoeff(), -4.0 - 2.0);  // 6 mm beyond the slab's side at y = −4
  EXPECT_NEAR(line.col(1).maxCoeff(), 20.0, 1.5 * kSpacing_mm);
}

TEST_F(JumpDetection, AnEndOverTheRimIsAnEnd) {
  Play(100);
  ASSERT_EQ(state.cuts.size(), 1u);
  const double over = state.cuts[0].line.points.col(1).minCoeff();
  state.frame = -1;
  Play(100);
  EXPECT_EQ(state.cuts[0].line.points.col(1).minCoeff(), over);
}

TEST_F(JumpDetection, WhatWasCommittedStaysAndTheLineIsRedrawnFromAllEvidence) {
  Play(75);
  ASSERT_EQ(state.cuts.size(), 1u);
  Points& line = state.cuts[0].line.points;
  // The tip was led 6 mm aside, by mistake.
  const Index tip = Tip(line);
  const double reached = line(tip, 1);
  line(tip, 0) += 6.0;
  const Vec3 led_aside = line.row(tip).transpose();
  Play(100);
  EXPECT_LT(DistanceToLine(line, led_aside), 1e-9);
  ASSERT_GT(state.cuts[0].redrawn.rows(), 1);
  EXPECT_LT(LargestOffset_mm(state.cuts[0].redrawn), 2.0);
  EXPECT_GE(state.cuts[0].redrawn.col(1).maxCoeff(), reached - 0.5);
  EXPECT_EQ(Tip(state.cuts[0].redrawn) == 0, Tip(line) == 0);  // in the same order
}

TEST_F(JumpDetection, ALittleEvidenceDoesNotLeadACutOn) {
  Know({kCut_mm, 4.0, 150.0}, {kCut_mm, 6.0, 150.0});
  const Points known = state.cuts[0].line.points;
  EXPECT_EQ(OpenAtOnce(6.0, kLittle), 0u);
  EXPECT_GT(parting, 0);  // there was some
  EXPECT_EQ(state.cuts[0].line.points, known);
  EXPECT_GT(OpenAtOnce(6.0, 4.0 * kLittle), 0u);
  EXPECT_GT(state.cuts[0].line.points.rows(), 2);
}

// An instrument hid what lies between.
TEST_F(JumpDetection, WhatPartsAheadOfACutGoesOnWithIt) {
  Know({kCut_mm, 38.0, 150.0}, {kCut_mm, 26.0, 150.0});
  EXPECT_GT(OpenAtOnce(10.0, 1.0), 0u);
  ASSERT_EQ(state.cuts.size(), 1u);
  const Points& line = state.cuts[0].line.points;
  EXPECT_LT(line.col(1).minCoeff(), 2.0);
  EXPECT_LT(LargestOffset_mm(line), 3.0);
}

// The same where the cut opens at once, on both sides of the instrument.
TEST_F(JumpDetection, ACutThatBeginsOnBothSidesOfAnInstrumentIsOne) {
  std::vector<char> usable = Everyone();
  for (Index i = 0; i < rest.rows(); ++i)
    if (rest(i, 1) > 8.0 && rest(i, 1) < 20.0) usable[i] = 0;
  EXPECT_GT(OpenAtOnce(36.0, 1.0, usable), 0u);
  ASSERT_EQ(state.cuts.size(), 1u);
  EXPECT_GT(state.cuts[0].line.points.col(1).maxCoeff(), 25.0);
  EXPECT_LT(state.cuts[0].line.points.col(1).minCoeff(), 2.0);
}

// That the organ ends there is what its surface says.
TEST_F(JumpDetection, OvershootingEvidenceLeadsALineOverTheRimAllTheSame) {
  Know({kCut_mm, 15.0, 150.0}, {kCut_mm, 7.0, 150.0});
  state.cuts[0].too_far_mm = {8.0, 8.0};
  EXPECT_GT(OpenAtOnce(20.0, 1.0), 0u);
  ASSERT_EQ(state.cuts.size(), 1u);
  const Points& line = state.cuts[0].line.points;
  EXPECT_LT(line.col(1).minCoeff(), -4.0 - 5.0);  // the slab's side is at y = −4
  EXPECT_EQ(line.col(1).maxCoeff(), 15.0);
}

TEST_F(JumpDetection, WhatPartsAcrossTheWayAheadIsAnother) {
  Know({kCut_mm - 30.0, 8.0, 150.0}, {kCut_mm - 15.0, 8.0, 150.0});
  EXPECT_GT(OpenAtOnce(10.0, 1.0), 0u);
  EXPECT_EQ(state.cuts.size(), 2u);
}

TEST_F(JumpDetection, WhatPartsFarBesideACutIsAnother) {
  Know({kCut_mm + 16.0, 20.0, 150.0}, {kCut_mm + 16.0, 8.0, 150.0});
  EXPECT_GT(OpenAtOnce(10.0, 1.0), 0u);
  EXPECT_EQ(state.cuts.size(), 2u);
}

}  // namespace
}  // namespace kerf
