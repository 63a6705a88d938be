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
  double LargestOffset_mm(const Points& line) const {
    return (line.col(0).array() - kCut_mm).abs().maxCoeff();
  }
  /// Number of the row of the deepest tip, where the cut ends inside the slab.
  Index Tip(const Points& line) const {
    return line(0, 1) > line(line.rows() - 1, 1) ? 0 : line.rows() - 1;
  }

  const Points rest = Scene();
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
  Play(100);
  ASSERT_EQ(state.cuts.size(), 1u);
  // Another cut's line, short, beside a single pair that parts by less than is wide.
  ModelCut& cut = state.cuts[0];
  cut.line.points = Points(cut.line.points.topRows(2));
  cut.line.points << kCut_mm, 2.0, 150.0, kCut_mm, 4.0, 150.0;
  const Points shortened = cut.line.points;
  CutEvidence begun = BeginEvidence(rest, Everyone());
  state.evidence = begun;
  for (state.frame = 0; state.frame < 40; ++state.frame) {
    Pixels now = rest.leftCols<2>();
    if (state.frame > 30)  // one feature beside the line moves on by 1 mm
      for (Index i = 0; i < rest.rows(); ++i)
        if ((now.row(i) - Eigen::RowVector2d(kCut_mm + 2.0, 9.0)).norm() < 2.5) now(i, 0) += 1.0;
    EXPECT_TRUE(DetectCutsByJumps(now, Everyone(), camera, options, &state).empty());
  }
  EXPECT_EQ(cut.line.points, shortened);
}

}  // namespace
}  // namespace kerf
