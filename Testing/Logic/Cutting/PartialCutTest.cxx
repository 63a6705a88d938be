// Cuts of which a part has to stay uncut: that they say so, and that it is tried again.
#include <gtest/gtest.h>

#include "Cutting/TetCutter.h"
#include "Fuzz/CutSequences.h"
#include "Fuzz/ShrinkSequence.h"
#include "Support/TestMeshes.h"

namespace kerf::testing {
namespace {

/// All through a band, at x.
CutSurface Across(double x) {
  return RectangleCut({x, -100, -100}, {0, 200, 0}, {0, 0, 200}, 66, 66);
}

/// Two sheets through a band of which the first uses up what the mesh may grow by: the second can
/// only be cut alone.
struct TwoSheets {
  TwoSheets() : cutter(Options()) {}
  static CutOptions Options() {
    CutOptions options;
    options.max_new_vertices = 0.9;
    return options;
  }
  void Cut(const CutSurface& s) { mesh = cutter.Cut(mesh, s, &report).mesh; }

  TetMesh mesh = BandMesh(3000);
  TetCutter cutter;
  CutReport report;
  const CutSurface both = Together(Across(-20.3), Across(15.2));
};

TEST(PartialCut, OneOfTwoSheetsIsRefusedAndTriedAgain) {
  TwoSheets band;
  band.Cut(band.both);
  ASSERT_TRUE(band.report.done);
  EXPECT_TRUE(band.report.partial);
  EXPECT_NE(band.report.reason.find("well shaped"), std::string::npos) << band.report.reason;
  EXPECT_EQ(band.report.components, 2);
  EXPECT_LE(band.report.new_vertices, 0.9 * band.report.crossed_tets);
  band.Cut(band.both);
  EXPECT_TRUE(band.report.done) << band.report.reason;
  EXPECT_FALSE(band.report.partial);
  EXPECT_EQ(band.report.components, 3);
  band.Cut(band.both);
  EXPECT_FALSE(band.report.done);
  EXPECT_FALSE(band.report.partial) << "nothing is left";
}

TEST(PartialCut, WhatIsLeftIsTriedAgainByAnIncrementThatComesNear) {
  TwoSheets band;
  band.Cut(band.both);
  ASSERT_TRUE(band.report.partial);
  band.Cut(Together(band.both, Across(10)));
  EXPECT_FALSE(band.report.partial) << band.report.reason;
  EXPECT_EQ(band.report.components, 4);
}

TEST(PartialCut, WhatIsLeftWaitsWhileSGrowsElsewhere) {
  TwoSheets band;
  band.Cut(band.both);
  ASSERT_TRUE(band.report.partial);
  const CutSurface grown = Together(band.both, Across(55.5));
  band.Cut(grown);
  EXPECT_TRUE(band.report.done);
  EXPECT_TRUE(band.report.partial) << "it is still uncut";
  EXPECT_FALSE(band.report.reason.empty());
  EXPECT_EQ(band.report.components, 3);
  const Index of_increment = band.report.crossed_tets;
  TwoSheets alone;
  alone.Cut(Across(55.5));
  EXPECT_EQ(of_increment, alone.report.crossed_tets) << "its cost is not that of what is left";
  band.Cut(grown);
  EXPECT_FALSE(band.report.partial);
  EXPECT_EQ(band.report.components, 4);
}

/// Seed 1925 has to look again at what its first round left to cut, and again.
struct TwoRounds {
  TopologyChange Cut(TetCutter* cutter) { return cutter->Cut(mesh, sequence.surfaces[0], &report); }

  CutSequence sequence = MakeCutSequence(1925);
  TetMesh mesh = sequence.mesh;
  CutReport report;
};

/// In seed 9 faces stand across the inside of a fold: closed, they would be left to a second round.
TEST(PartialCut, FacesAcrossAFoldAreOpenedAtOnce) {
  const CutSequence sequence = MakeCutSequence(9);
  const TetMesh mesh = TetCutter().Cut(sequence.mesh, sequence.surfaces[0]).mesh;
  CutOptions one_round;
  one_round.rounds = 1;
  CutReport report;
  TetCutter(one_round).Cut(mesh, sequence.surfaces[1], &report);
  EXPECT_TRUE(report.done);
  EXPECT_FALSE(report.partial) << report.reason;
}

TEST(PartialCut, RoundsThatRunOutAreSaidAndGoOnInTheNextCall) {
  TwoRounds scene;
  TetCutter whole;
  scene.Cut(&whole);
  ASSERT_TRUE(scene.report.done && !scene.report.partial) << scene.report.reason;
  const CutReport expected = scene.report;

  CutOptions one_round;
  one_round.rounds = 1;
  TetCutter cutter(one_round);
  scene.mesh = scene.Cut(&cutter).mesh;
  ASSERT_TRUE(scene.report.done);
  EXPECT_TRUE(scene.report.partial);
  EXPECT_NE(scene.report.reason.find("left more"), std::string::npos) << scene.report.reason;
  EXPECT_LT(scene.report.new_vertices, expected.new_vertices);
  for (int call = 0; call < 3 && scene.report.partial; ++call) {
    scene.mesh = scene.Cut(&cutter).mesh;
    EXPECT_TRUE(scene.report.done || !scene.report.partial) << "neither cut nor settled";
    EXPECT_LT(scene.report.crossed_tets, expected.crossed_tets / 2) << "only what was left";
  }
  EXPECT_FALSE(scene.report.partial) << scene.report.reason;
  EXPECT_EQ(scene.report.components, expected.components);
}

TEST(PartialCut, ALaterRoundThatIsRefusedIsSaidAndTriedAgain) {
  TwoRounds scene;
  TetCutter whole;
  scene.Cut(&whole);
  ASSERT_FALSE(scene.report.partial);
  CutOptions tight;  // enough for the first round, but not for what it leaves
  tight.max_new_vertices = (scene.report.new_vertices - 5.5) / scene.report.crossed_tets;
  TetCutter cutter(tight);
  const TopologyChange part = scene.Cut(&cutter);
  ASSERT_TRUE(part.changed);
  EXPECT_TRUE(scene.report.partial);
  EXPECT_NE(scene.report.reason.find("well shaped"), std::string::npos) << scene.report.reason;
  scene.mesh = part.mesh;
  const Index at_first = scene.report.crossed_tets;
  scene.mesh = scene.Cut(&cutter).mesh;
  EXPECT_GT(scene.report.crossed_tets, 0) << "tried again, not settled";
  EXPECT_LT(scene.report.crossed_tets, at_first);
  if (scene.report.partial) scene.mesh = scene.Cut(&whole).mesh;
  EXPECT_FALSE(scene.report.partial) << scene.report.reason;
}

/// Shrunk sequences of the fuzz where a face stays closed, away from the end of S, since the
/// boundary would touch itself in a vertex. They say so, and keep every guarantee.
TEST(PartialCut, FacesThatStayClosedForAPinchAreSaid) {
  struct Case {
    unsigned seed;
    std::vector<KeptIncrement> kept;
  };
  int said = 0;
  for (const Case& c : {Case{449, {{4, 7, 10}, {6, 9, 30}}}, Case{864, {{6, 17, 57}, {8, 12, 100}}},
                        Case{1056, {{4, 2, 4}, {5, 0, 8}}}, Case{1728, {{2, 25, 37}, {3, 2, 50}}},
                        Case{1943, {{1, 18, 33}, {2, 24, 68}}}}) {
    const CutSequence sequence = Kept(MakeCutSequence(c.seed), c.kept, false);
    EXPECT_EQ(RunCutSequence(sequence).failure, "") << c.seed;
    TetMesh mesh = sequence.mesh;
    TetCutter cutter;
    for (const CutSurface& surface : sequence.surfaces) {
      CutReport report;
      mesh = cutter.Cut(mesh, surface, &report).mesh;
      said +=
          report.done && report.partial && report.reason.find("touch itself") != std::string::npos;
    }
  }
  EXPECT_GE(said, 3);
}

}  // namespace
}  // namespace kerf::testing
