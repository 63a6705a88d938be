// Whether a cut of the model is in it in whole or in part, as it grows, is cut anew and taken over.
#include <gtest/gtest.h>

#include <algorithm>

#include "Registration/CutLine.h"
#include "Registration/ModelSearch.h"
#include "Registration/ModelUpdate.h"
#include "Registration/Silhouette.h"
#include "Support/TestMeshes.h"

namespace kerf::testing {
namespace {

class NoTracker : public FeatureTracker {
 public:
  FeatureSet Detect(const Frame&, const Image&, int) override { return {}; }
  void Track(const Frame&, FeatureSet*) override {}
};

CutSurface Across(double x) {
  return RectangleCut({x, -100, -100}, {0, 200, 0}, {0, 0, 200}, 66, 66);
}

/// A band with a cut of two sheets; the mesh may grow by enough for the first of them only.
struct Band {
  Band() : cutter(Tight()), engine{tracker, solvers, cutter} {
    state.mesh = BandMesh(3000);
    state.positions = state.mesh.rest;
    state.velocities = Points::Zero(state.mesh.VertexCount(), 3);
    state.blind_outline.resize(1, 3);
    state.blind_outline.row(0) = state.mesh.rest.colwise().maxCoeff();
    state.boundary = MakeBoundaryTopology(state.mesh, state.blind_outline);
    state.bound.embedding.weights.resize(0, 4);
    state.bound.rest.resize(0, 3);
    const auto solver = MakeKerfSolver();
    state.grips = BeginGrips(state.mesh, state.bound, options.material, {}, solver.get());
    auto uncut = std::make_shared<UncutModel>();
    uncut->mesh = state.mesh;
    uncut->features = state.bound.embedding;
    state.origin = uncut;
    solvers.organ = MakeKerfSolver();
    solvers.organ->Reset(state.mesh, options.material);
    state.cuts.resize(1);
    cut().surface = Together(Across(-20.3), Across(15.2));
    cut().line.points = cut().surface.points.topRows(2);
  }
  static CutOptions Tight(double new_vertices = 0.9) {
    CutOptions tight;
    tight.max_new_vertices = new_vertices;
    return tight;
  }
  ModelCut& cut() { return state.cuts[0]; }
  CutReport Apply() { return ApplyCut(cut(), options, engine, &state); }

  NoTracker tracker;
  Solvers solvers;
  TetCutter cutter;
  MethodOptions options;
  Engine engine;
  RegistrationState state;
};

TEST(ModelUpdate, ACutSaysWhetherItIsInTheModelInPart) {
  Band band;
  EXPECT_TRUE(band.Apply().partial);
  EXPECT_TRUE(band.cut().in_model);
  EXPECT_TRUE(band.cut().partial);
  EXPECT_TRUE(band.Apply().done) << "what was left can be cut alone";
  EXPECT_FALSE(band.cut().partial) << "now it is whole";
  EXPECT_FALSE(band.Apply().done) << "nothing is left";
  EXPECT_FALSE(band.cut().partial);
}

TEST(ModelUpdate, GrowthThatIsRefusedMakesItPartial) {
  Band band;
  band.cut().surface = Across(15.2);
  EXPECT_TRUE(band.Apply().done);
  EXPECT_FALSE(band.cut().partial);
  band.cutter = TetCutter(Band::Tight(0.01));
  band.cut().surface = Together(Across(15.2), Across(-20.3));
  const CutReport refused = band.Apply();
  EXPECT_FALSE(refused.done);
  EXPECT_TRUE(refused.partial);
  EXPECT_TRUE(band.cut().in_model);
  EXPECT_TRUE(band.cut().partial) << "the model is not cut along all of S";
}

// Vertex by vertex and in the same order: the outline takes the first edge that it meets.
TEST(ModelUpdate, TheBoundaryFollowsAGrowingCutAsIfItWereMadeAnew) {
  Band band;
  band.cutter = TetCutter();
  band.state.blind_outline.row(0) << -19.0, -20.0, 5.0;  // where the cut enters
  band.state.boundary = MakeBoundaryTopology(band.state.mesh, band.state.blind_outline);
  const auto blind = [&] {
    const std::vector<char>& flags = band.state.boundary.blind;
    return std::count(flags.begin(), flags.end(), 1);
  };
  const auto blind_at_rest = blind();
  ASSERT_GT(blind_at_rest, 0);
  for (int depth : {10, 20, 41}) {
    const Index triangles = band.state.boundary.triangles.rows();
    band.cut().surface = RectangleCut({-20.3, -22, -9}, {0, depth + 2.0, 0}, {0, 0, 18}, 12, 8);
    ASSERT_TRUE(band.Apply().done);
    const BoundaryTopology& followed = band.state.boundary;
    const BoundaryTopology anew = MakeBoundaryTopology(band.state.mesh, band.state.blind_outline);
    EXPECT_GT(followed.triangles.rows(), triangles);
    EXPECT_EQ(followed.triangles, anew.triangles);
    EXPECT_EQ(followed.tet_of_triangle, anew.tet_of_triangle);
    EXPECT_EQ(followed.edges, anew.edges);
    EXPECT_EQ(followed.beside, anew.beside);
    EXPECT_EQ(followed.blind, anew.blind);
    EXPECT_EQ(followed.tet_of_vertex, anew.tet_of_vertex);
  }
  EXPECT_GT(blind(), blind_at_rest);  // both lips of the cut
}

TEST(ModelUpdate, ACutThatIsRefusedIsNotInTheModel) {
  Band band;
  band.cutter = TetCutter(Band::Tight(0.01));
  EXPECT_TRUE(band.Apply().partial);
  EXPECT_FALSE(band.cut().in_model || band.cut().partial);
}

TEST(ModelUpdate, CutAnewItSaysWhatItIsNow) {
  Band band;
  EXPECT_TRUE(band.Apply().partial);
  auto whole = CutAnew(band.state.cuts, band.options, band.state, true);
  ASSERT_TRUE(whole);
  EXPECT_EQ(whole->uncut, std::vector<std::string>{""});
  Adopt(std::move(*whole), band.options, band.engine, &band.state);
  EXPECT_FALSE(band.cut().partial);
  EXPECT_EQ(MeasureQuality(band.state.mesh, band.state.mesh.rest).components, 3);

  auto part = CutAnew(band.state.cuts, band.options, band.state, true);
  ASSERT_TRUE(part);
  part->uncut[0] = "for a reason";
  Adopt(std::move(*part), band.options, band.engine, &band.state);
  EXPECT_TRUE(band.cut().partial);
}

TEST(ModelUpdate, WhatASearchFoundSaysWhatWasLeftUncut) {
  Band band;
  EXPECT_TRUE(band.Apply().partial);
  for (const char* why : {"for a reason", ""}) {
    band.cut().surface = Together(Across(-20.3), Across(15.2));
    auto then = std::make_shared<RegistrationState>(band.state);
    BetterModel better;
    better.then = then;
    better.by = BetterModel::By::Turned;
    better.instead = band.cut();
    auto anew = CutAnew(band.state.cuts, band.options, band.state, true);
    ASSERT_TRUE(anew);
    better.model = std::move(*anew);
    better.model.uncut[0] = why;
    better.fitted = band.state.grips;
    better.fitted.positions = better.model.grip_positions;
    const CutEvent event = TakeOver(std::move(better), band.options, band.engine, &band.state);
    EXPECT_TRUE(event.report.done);
    EXPECT_EQ(event.report.reason, why);
    EXPECT_EQ(event.report.partial, *why != 0);
    EXPECT_EQ(band.cut().partial, *why != 0);
  }
}

/// What a search found along another line, while the cut went on at one end or not.
TEST(ModelUpdate, GrowthSinceASearchBeganIsKept) {
  for (const bool has_grown : {false, true}) {
    Band band;
    band.cutter = TetCutter();
    band.cut().direction = {0, 0, -1};
    band.cut().depth_mm = 60.0;
    band.cut().line.points = (Points(2, 3) << -20.3, -8.0, 2.5, -20.3, 0.0, 2.5).finished();
    band.cut().surface = ExtrudeCut(band.cut().line, band.cut().direction, band.cut().depth_mm);
    ASSERT_TRUE(band.Apply().done);
    BetterModel better;
    better.then = std::make_shared<RegistrationState>(band.state);
    better.by = BetterModel::By::Redrawn;
    better.shorter_mm[1] = 2.0;
    better.instead = band.cut();
    better.instead.line.points.row(1).x() += 1.0;
    better.instead.surface =
        ExtrudeCut(better.instead.line, better.instead.direction, better.instead.depth_mm);
    auto anew = CutAnew({better.instead}, band.options, band.state, true);
    ASSERT_TRUE(anew);
    better.model = std::move(*anew);
    better.fitted = band.state.grips;
    better.fitted.positions = better.model.grip_positions;
    const Vec3 tip(-20.3, 5.0, 2.5);
    if (has_grown) {
      band.cut().line.points = LedOn(band.cut().line.points, true, tip);
      band.cut().surface = ExtrudeCut(band.cut().line, band.cut().direction, band.cut().depth_mm);
      ASSERT_TRUE(band.Apply().done);
    }
    const Index cut_along_what_was_found = better.model.mesh.VertexCount();
    EXPECT_TRUE(TakeOver(std::move(better), band.options, band.engine, &band.state).report.done);
    const Points& line = band.cut().line.points;
    EXPECT_EQ(line.rows(), has_grown ? 3 : 2);
    EXPECT_NEAR(line(1, 0), -19.3, 1e-9) << "the line is the one that was found";
    if (has_grown) {
      EXPECT_LT((line.row(2).transpose() - tip).norm(), 1e-9);
    }
    EXPECT_EQ(band.state.mesh.VertexCount() > cut_along_what_was_found, has_grown);
    EXPECT_EQ(band.cut().too_far_mm[1], has_grown ? 0.0 : 2.0);
  }
}

}  // namespace
}  // namespace kerf::testing
