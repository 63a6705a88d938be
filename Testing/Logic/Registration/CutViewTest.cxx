#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <utility>

#include "Cutting/TetCutter.h"
#include "Geometry/EmbedPoints.h"
#include "Registration/CutLine.h"
#include "Registration/CutView.h"
#include "Registration/ModelUpdate.h"
#include "Support/TestMeshes.h"

namespace kerf {
namespace {

constexpr double kFront_mm = -7.5, kAt_mm = 1.3;

/// A block seen along z, cut right through across x, with a tumour on the left of the cut.
RegistrationState CutBlock() {
  RegistrationState state;
  state.mesh = testing::BoxMesh(Vec3(60, 30, 15), 12, 6, 3);
  state.positions = state.mesh.rest;
  state.uncut = std::make_shared<SurfaceTree>(BoundarySurface(state.mesh, state.mesh.rest));
  ModelCut cut;
  cut.direction = Vec3::UnitZ();
  cut.line.points.resize(3, 3);
  cut.line.points << kAt_mm, -20, kFront_mm, kAt_mm, 0, kFront_mm, kAt_mm, 20, kFront_mm;
  cut.surface = ExtrudeCut(cut.line, cut.direction, 40);
  TetCutter cutter;
  CutReport report;
  const TopologyChange change = cutter.Cut(state.mesh, cut.surface, &report, &state.positions);
  EXPECT_TRUE(report.done) << report.reason;
  state.positions = change.MapVertexField(state.positions);
  state.mesh = change.mesh;
  state.cuts.push_back(cut);
  const SurfaceMesh tumour = testing::SphereSurface(Vec3(-10, 0, 0), 3.0, 2);
  state.structures.push_back({"tumour", tumour, EmbedPoints(state.mesh, tumour.points)});
  return state;
}

/// Moves the right piece away.
void Open(double by_mm, RegistrationState* state) {
  std::vector<Index> piece;
  ASSERT_EQ(TetComponents(state->mesh.tets, &piece), 2);
  std::vector<char> moved(state->mesh.VertexCount(), 0);
  for (Index t = 0; t < state->mesh.TetCount(); ++t) {
    double x = 0;
    for (int k = 0; k < 4; ++k) x += state->mesh.rest(state->mesh.tets(t, k), 0) / 4;
    for (int k = 0; k < 4 && x > kAt_mm; ++k) {
      const Index v = state->mesh.tets(t, k);
      if (!moved[v]) state->positions(v, 0) += by_mm;
      moved[v] = 1;
    }
  }
}

TEST(CutView, NothingWithoutACut) {
  RegistrationState state = CutBlock();
  state.cuts.clear();
  CutView view;
  view.Update(state);
  EXPECT_TRUE(view.Lips().empty());
  EXPECT_TRUE(std::isnan(view.TumourMargin_mm()));
}

/// Extent along x of all lips.
std::pair<double, double> Across(const CutView& view) {
  double low = 1e9, high = -1e9;
  for (const Points& lip : view.Lips()) {
    low = std::min(low, lip.col(0).minCoeff());
    high = std::max(high, lip.col(0).maxCoeff());
  }
  return {low, high};
}

TEST(CutView, LipsPartAsTheCutOpens) {
  RegistrationState state = CutBlock();
  CutView view;
  view.Update(state);
  ASSERT_FALSE(view.Lips().empty());
  double length = 0;
  for (const Points& lip : view.Lips()) {
    EXPECT_LT((lip.col(2).array() - kFront_mm).abs().maxCoeff(), 5.1)
        << "on the surface and a cell down the flank, not on the far side";
    for (Index i = 0; i + 1 < lip.rows(); ++i) length += (lip.row(i + 1) - lip.row(i)).norm();
  }
  EXPECT_GT(length, 2 * 29.0) << "both lips, over the whole width";
  EXPECT_NEAR(Across(view).first, kAt_mm, 0.1);
  EXPECT_NEAR(Across(view).second, kAt_mm, 0.1);
  Open(6.0, &state);
  view.Update(state);
  EXPECT_NEAR(Across(view).first, kAt_mm, 0.1);
  EXPECT_NEAR(Across(view).second, kAt_mm + 6.0, 0.1);
  for (const Points& lip : view.Lips())
    for (Index i = 0; i + 1 < lip.rows(); ++i)
      EXPECT_LT((lip.row(i + 1) - lip.row(i)).norm(), 6.0) << "no line leaps over the opening";
  EXPECT_EQ(view.LipCuts().size(), view.Lips().size());
}

TEST(CutView, FlagsOfAnotherModelAreNotUsed) {
  const RegistrationState state = CutBlock();
  CutView own;
  own.Update(state);
  ASSERT_FALSE(own.Lips().empty());
  for (const std::size_t size : {0, 5, 100000}) {
    const std::vector<std::uint8_t> others(size, 1);
    CutView view;
    view.Update(state, &others);
    ASSERT_EQ(view.Lips().size(), own.Lips().size());
    for (std::size_t i = 0; i < own.Lips().size(); ++i) EXPECT_EQ(view.Lips()[i], own.Lips()[i]);
    EXPECT_EQ(view.TumourMargin_mm(), own.TumourMargin_mm());
  }
}

/// As many vertices and tetrahedra, numbered the other way round.
RegistrationState Renumbered(RegistrationState state) {
  const Index last = state.mesh.VertexCount() - 1;
  const Points rest = state.mesh.rest, positions = state.positions;
  state.mesh.rest = rest.colwise().reverse();
  state.positions = positions.colwise().reverse();
  state.mesh.tets = (last - state.mesh.tets.array()).matrix();
  return state;
}

TEST(CutView, AnotherModelWithAsManyElementsIsLookedAtAnew) {
  RegistrationState state = CutBlock();
  state.structures.clear();
  CutView kept;
  kept.Update(state);
  RegistrationState other = Renumbered(state);
  CutView fresh;
  fresh.Update(other);
  kept.Update(other);
  ASSERT_FALSE(fresh.Lips().empty());
  ASSERT_EQ(kept.Lips().size(), fresh.Lips().size());
  for (std::size_t l = 0; l < fresh.Lips().size(); ++l) EXPECT_EQ(kept.Lips()[l], fresh.Lips()[l]);
  // A line of as many points elsewhere, which the model is not cut along yet.
  for (auto* s : {&state, &other}) s->cuts[0].line.points.col(0).array() += 12.0;
  kept.Update(other);
  ASSERT_EQ(kept.Lips().size(), 1u);
  EXPECT_NEAR(kept.Lips()[0].col(0).mean(), kAt_mm + 12.0, 0.01);
}

TEST(CutView, LipsEndWhereTheLineEndsNotAtTheNextVertex) {
  RegistrationState state;
  state.mesh = testing::BoxMesh(Vec3(60, 30, 15), 12, 6, 3);  // elements of 5 mm
  state.positions = state.mesh.rest;
  state.uncut = std::make_shared<SurfaceTree>(BoundarySurface(state.mesh, state.mesh.rest));
  ModelCut cut;
  cut.direction = Vec3::UnitZ();
  const double end_mm = 2.4;
  cut.line.points.resize(2, 3);
  cut.line.points << kAt_mm, -20, kFront_mm, kAt_mm, end_mm, kFront_mm;
  cut.surface = ExtrudeCut(cut.line, cut.direction, 40);
  TetCutter cutter;
  const TopologyChange change =
      cutter.Cut(state.mesh, cut.surface, static_cast<CutReport*>(nullptr), &state.positions);
  ASSERT_TRUE(change.changed);
  state.positions = change.MapVertexField(state.positions);
  state.mesh = change.mesh;
  state.cuts.push_back(cut);
  CutView view;
  view.Update(state);
  ASSERT_FALSE(view.Lips().empty());
  double low = 1e9, high = -1e9, length = 0;
  for (const Points& lip : view.Lips()) {
    low = std::min(low, lip.col(1).minCoeff());
    high = std::max(high, lip.col(1).maxCoeff());
    for (Index i = 0; i + 1 < lip.rows(); ++i) length += (lip.row(i + 1) - lip.row(i)).norm();
  }
  EXPECT_NEAR(low, -15, 0.1);
  EXPECT_LT(high, end_mm + 0.1);
  EXPECT_GT(high, end_mm - 2.5);
  EXPECT_GT(length, 2 * 14.0) << "both lips";
}

TEST(CutView, AProposedCutIsALineOnTheSurface) {
  RegistrationState state = CutBlock();
  ModelCut proposed = state.cuts[0];
  proposed.line.points.col(0).array() -= 20;
  state.cuts.push_back(proposed);
  state.positions.col(1).array() += 3;
  CutView view;
  view.Update(state);
  ASSERT_EQ(view.LipCuts().back(), 1);
  const Points& line = view.Lips().back();
  EXPECT_LT((line.col(0).array() - (kAt_mm - 20)).abs().maxCoeff(), 0.01);
  EXPECT_LT((line.col(2).array() - kFront_mm).abs().maxCoeff(), 0.01);
  EXPECT_NEAR(line.col(1).maxCoeff(), 15 + 3, 1.1);
}

TEST(CutView, MarginIsTheDistanceFromTumourToCut) {
  RegistrationState state = CutBlock();
  CutView view;
  view.Update(state);
  EXPECT_NEAR(view.TumourMargin_mm(), kAt_mm + 10.0 - 3.0, 0.1);
  Open(6.0, &state);  // the face on the tumour's own side stays where it is
  view.Update(state);
  EXPECT_NEAR(view.TumourMargin_mm(), kAt_mm + 10.0 - 3.0, 0.1);
  state.structures.clear();
  view.Update(state);
  EXPECT_TRUE(std::isnan(view.TumourMargin_mm()));
}

/// Most points are not asked for, since they cannot be the nearest: the same comes out.
TEST(CutView, MarginOnABentOrganIsThatOfAllPoints) {
  RegistrationState state = CutBlock();
  for (const double bend : {0.0, 0.3, -0.7}) {
    state.positions = state.mesh.rest;
    for (Index v = 0; v < state.positions.rows(); ++v) {
      const double x = state.mesh.rest(v, 0), y = state.mesh.rest(v, 1);
      state.positions(v, 0) += bend * 0.04 * y * y;
      state.positions(v, 2) += bend * (0.02 * x * x + 0.1 * y);
    }
    CutView view;
    view.Update(state);
    const SurfaceMesh rest = BoundarySurface(state.mesh, state.mesh.rest);
    const std::vector<std::uint8_t> is_cut = CutFaceFlags(rest, *state.uncut);
    SurfaceMesh faces = BoundarySurface(state.mesh, state.positions);
    Index kept = 0;
    for (Index t = 0; t < rest.triangles.rows(); ++t)
      if (is_cut[t]) faces.triangles.row(kept++) = rest.triangles.row(t);
    faces.triangles.conservativeResize(kept, 3);
    const Structure& tumour = state.structures[0];
    const SurfaceMesh moved{tumour.embedding.Positions(state.positions, state.mesh.tets),
                            tumour.rest.triangles};
    double smallest = 1e9;
    const auto ask_all = [&](const SurfaceMesh& from, const SurfaceMesh& to) {
      const SurfaceTree tree(to);
      for (Index i = 0; i < from.triangles.size(); ++i)
        smallest = std::min(
            smallest,
            tree.Closest(from.points.row(from.triangles.data()[i]).transpose()).distance_mm);
    };
    ask_all(moved, faces);
    ask_all(faces, moved);
    EXPECT_NEAR(view.TumourMargin_mm(), smallest, 1e-9) << bend;
  }
}

}  // namespace
}  // namespace kerf
