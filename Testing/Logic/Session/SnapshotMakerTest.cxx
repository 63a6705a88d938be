// What a snapshot says of a cut: how far it is from the plan, and how it was before it.
#include <gtest/gtest.h>

#include "CrackedBand.h"
#include "Session/SnapshotMaker.h"

namespace kerf {
namespace {

using namespace testing;

/// A plane across the band at x, larger than the band.
SurfaceMesh PlaneAt(double x) {
  SurfaceMesh plane;
  plane.points.resize(4, 3);
  plane.points << x, -60, -60, x, 60, -60, x, 60, 60, x, -60, 60;
  plane.triangles.resize(2, 3);
  plane.triangles << 0, 1, 2, 0, 2, 3;
  return plane;
}

SurfaceMesh Uncut() { return BoundarySurface(BandMesh(3000), BandMesh(3000).rest); }

TEST(SnapshotMaker, TheDistanceBetweenPlanAndCutIsExact) {
  for (const double aside_mm : {0.0, 2.5}) {
    BandRun run;
    run.RunTo(5);
    SnapshotMaker maker(Uncut(), {{}, PlaneAt(0.7 + aside_mm)});
    Frame frame;
    frame.index = 4;
    SessionFrame report;
    report.reliability.state = GateState::Green;
    const auto uncut = maker.Make(frame, report, run.State());
    EXPECT_TRUE(std::isnan(uncut->deviation.mean_mm)) << "no cut, no distance";
    CutReport cut;
    ASSERT_EQ(run.session->DrawCut(AcrossBand(0.7), Vec3(0, 0, -1), 0, &cut), 0);
    ASSERT_TRUE(cut.done) << cut.reason;
    const auto after = maker.Make(frame, report, run.State());
    // Planes that are parallel: every place is as far away, whatever the band does meanwhile.
    EXPECT_NEAR(after->deviation.mean_mm, aside_mm, 0.15);
    EXPECT_GE(after->deviation.p95_mm, after->deviation.mean_mm - 1e-9);
    EXPECT_GE(after->deviation.max_mm, after->deviation.p95_mm);
    EXPECT_NEAR(after->deviation.max_mm, aside_mm, 1.0);
    ASSERT_EQ(after->cuts.size(), 1u);
    EXPECT_EQ(after->cuts[0].before, uncut);
    run.RunTo(25);
    const auto later = maker.Make(frame, report, run.State());
    EXPECT_DOUBLE_EQ(later->deviation.mean_mm, after->deviation.mean_mm);
  }
}

TEST(SnapshotMaker, WhatWasBeforeACutShowsNoCutThatWasTakenOutSince) {
  BandRun run;
  run.RunTo(5);
  SnapshotMaker maker(Uncut(), {});
  Frame frame;
  SessionFrame report;
  report.reliability.state = GateState::Green;
  const auto uncut = maker.Make(frame, report, run.State());
  run.session->DrawCut(AcrossBand(-20), Vec3(0, 0, -1), 0, nullptr);
  const auto one = maker.Make(frame, report, run.State());
  run.session->DrawCut(AcrossBand(20), Vec3(0, 0, -1), 0, nullptr);
  EXPECT_EQ(maker.Make(frame, report, run.State())->cuts[1].before, one);
  ASSERT_TRUE(run.session->RejectCut(0));
  const auto rejected = maker.Make(frame, report, run.State());
  EXPECT_EQ(rejected->cuts[0].before, nullptr);
  EXPECT_EQ(rejected->cuts[1].before, uncut);
  EXPECT_NE(run.session->Undo().what, "");
  EXPECT_EQ(maker.Make(frame, report, run.State())->cuts[1].before, one);
}

TEST(SnapshotMaker, ACutMadeInPartIsListedAsSuch) {
  BandRun run;
  run.RunTo(5);
  ASSERT_EQ(run.session->DrawCut(AcrossBand(0.0), Vec3(0, 0, -1), 0, nullptr), 0);
  RegistrationState state = run.State();
  for (const bool partial : {false, true}) {
    state.cuts[0].partial = partial;
    SnapshotMaker maker(Uncut(), {{}, {}});
    EXPECT_EQ(maker.Make({}, {}, state)->cuts[0].partial, partial);
  }
}

TEST(SnapshotMaker, ATiltedPlanIsFartherWhereItTilts) {
  BandRun run;
  run.RunTo(5);
  ASSERT_EQ(run.session->DrawCut(AcrossBand(0.0), Vec3(0, 0, -1), 0, nullptr), 0);
  SurfaceMesh tilted = PlaneAt(0.0);  // turned by 45 degrees about z: a point at y is y/√2 away
  for (Index p = 0; p < 4; ++p) tilted.points(p, 0) = tilted.points(p, 1);
  SnapshotMaker maker(Uncut(), {{}, tilted});
  const auto snapshot = maker.Make({}, {}, run.State());
  EXPECT_NEAR(snapshot->deviation.mean_mm, 10 / std::sqrt(2.0), 0.5);  // |y| to 20: 10 in the mean
  EXPECT_NEAR(snapshot->deviation.p95_mm, 19 / std::sqrt(2.0), 1.0);
}

}  // namespace
}  // namespace kerf
