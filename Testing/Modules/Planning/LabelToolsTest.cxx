#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "Core/Errors.h"
#include "Session/PlanningLabels.h"
#include "Session/PlanningTools.h"

namespace kerf {
namespace {

GridGeometry Grid(int n = 24) {
  GridGeometry grid;
  grid.size = {n, n + 2, n - 3};
  grid.spacing_mm = {1, 1.5, 2};
  grid.origin_mm = {-10, 4, 30};
  return grid;
}

/// Voxels within `radius_mm` of the middle get `label`.
LabelMap Ball(const GridGeometry& grid, double radius_mm, int label = 1) {
  LabelMap labels;
  labels.grid = grid;
  labels.source = "ball";
  auto voxels = std::make_shared<std::vector<std::uint8_t>>(grid.VoxelCount(), 0);
  const Vec3 middle = 0.5 * grid.size.cast<double>();
  for (int k = 0; k < grid.size[2]; ++k)
    for (int j = 0; j < grid.size[1]; ++j)
      for (int i = 0; i < grid.size[0]; ++i)
        if ((Vec3(i, j, k) - middle).cwiseProduct(grid.spacing_mm).norm() <= radius_mm)
          (*voxels)[grid.Offset(i, j, k)] = static_cast<std::uint8_t>(label);
  labels.voxels = voxels;
  return labels;
}

LabelMap With(const LabelMap& labels, LabelVoxels voxels) {
  LabelMap other = labels;
  other.voxels = std::make_shared<const LabelVoxels>(std::move(voxels));
  return other;
}

std::size_t CountOf(const LabelVoxels& v, int label) {
  return std::size_t(std::count(v.begin(), v.end(), label));
}

std::size_t Middle(const GridGeometry& g) {
  return g.Offset(g.size[0] / 2, g.size[1] / 2, g.size[2] / 2);
}

Progress silent;

}  // namespace

TEST(LabelEditor, StrokeIsExactlyUndone) {
  LabelEditor editor;
  editor.Reset(CountLabels(Ball(Grid(), 9)));
  const LabelMap before = editor.Snapshot();
  LabelEditor::Brush brush;
  brush.radius_mm = 4;
  brush.paint = 2;
  editor.BeginStroke();
  editor.Dab(brush, Vec3(12, 12, 10), nullptr);
  editor.Dab(brush, Vec3(13, 12, 10), nullptr);
  const LabelDelta delta = editor.EndStroke();
  ASSERT_FALSE(delta.Empty());
  EXPECT_GT(editor.Count(2), 10u);
  const LabelVoxels painted = *editor.Labels().voxels;
  editor.Apply(delta, false);
  EXPECT_EQ(*editor.Labels().voxels, *before.voxels);
  EXPECT_EQ(editor.Count(2), 0u);
  editor.Apply(delta, true);
  EXPECT_EQ(*editor.Labels().voxels, painted);
  EXPECT_EQ(editor.Count(2), CountOf(painted, 2));
}

TEST(LabelEditor, WhatWasHandedOutNeverChanges) {
  LabelEditor editor;
  editor.Reset(Grid(), "ct");
  const LabelMap snapshot = editor.Snapshot();
  editor.BeginStroke();
  editor.Dab({}, Vec3(5, 5, 5), nullptr);
  editor.EndStroke();
  EXPECT_EQ(CountOf(*snapshot.voxels, 1), 0u);
  EXPECT_GT(CountOf(*editor.Labels().voxels, 1), 0u);
}

TEST(LabelEditor, AnEditIsTakenOverAndUndone) {
  LabelEditor editor;
  editor.Reset(CountLabels(Ball(Grid(), 9)));
  const LabelMap before = editor.Snapshot();
  const LabelMap after = Ball(Grid(), 6, 2);
  const LabelDelta delta = editor.Replace(CompareLabels(before, *after.voxels));
  EXPECT_EQ(*editor.Labels().voxels, *after.voxels);
  EXPECT_EQ(editor.Count(1), 0u);
  EXPECT_EQ(editor.Count(2), CountOf(*after.voxels, 2));
  editor.Apply(delta, false);
  EXPECT_EQ(*editor.Labels().voxels, *before.voxels);
  EXPECT_EQ(editor.Count(1), CountOf(*before.voxels, 1));
}

TEST(LabelEditor, AnEditOfLabelsThatWereChangedSinceIsComparedAnew) {
  LabelEditor editor;
  editor.Reset(Grid(), "ct");
  const LabelMap after = Ball(Grid(), 6, 2);
  const LabelEdit edit = CompareLabels(editor.Snapshot(), *after.voxels);
  editor.BeginStroke();
  editor.Dab({}, Vec3(5, 5, 5), nullptr);
  const LabelVoxels dabbed = *editor.Labels().voxels;
  const LabelDelta delta = editor.Replace(edit);
  EXPECT_EQ(*editor.Labels().voxels, *after.voxels);
  EXPECT_EQ(editor.Count(1), 0u);
  editor.Apply(delta, false);
  EXPECT_EQ(*editor.Labels().voxels, dabbed);
  EXPECT_EQ(editor.Count(1), CountOf(dabbed, 1));
}

TEST(LabelEditor, FlatBrushStaysInItsSliceAndBallDoesNot) {
  for (const int axis : {0, 1, 2, -1}) {
    LabelEditor editor;
    editor.Reset(Grid(), "ct");
    LabelEditor::Brush brush;
    brush.radius_mm = 5;
    brush.flat_axis = axis;
    editor.BeginStroke();
    editor.Dab(brush, Vec3(11, 11, 9), nullptr);
    editor.EndStroke();
    Eigen::Vector3i low = editor.Labels().grid.size, high = -Eigen::Vector3i::Ones();
    const GridGeometry& g = editor.Labels().grid;
    for (int k = 0; k < g.size[2]; ++k)
      for (int j = 0; j < g.size[1]; ++j)
        for (int i = 0; i < g.size[0]; ++i)
          if ((*editor.Labels().voxels)[g.Offset(i, j, k)]) {
            low = low.cwiseMin(Eigen::Vector3i(i, j, k));
            high = high.cwiseMax(Eigen::Vector3i(i, j, k));
          }
    for (int a = 0; a < 3; ++a) {
      if (a == axis)
        EXPECT_EQ(low[a], high[a]);
      else
        EXPECT_EQ(high[a] - low[a], 2 * int(5 / g.spacing_mm[a]));
    }
  }
}

TEST(LabelTools, HolesAndIslandsAreFoundAndRepaired) {
  LabelMap labels = Ball(Grid(), 9);
  LabelVoxels voxels = *labels.voxels;
  const GridGeometry& g = labels.grid;
  voxels[Middle(g)] = 0;          // a hole
  voxels[g.Offset(1, 1, 1)] = 1;  // an island
  labels = With(labels, voxels);
  const auto findings = CheckLabels(labels, silent);
  ASSERT_EQ(findings.size(), 2u);
  EXPECT_EQ(findings[0].kind, LabelFinding::Kind::Islands);
  EXPECT_EQ(findings[1].kind, LabelFinding::Kind::Holes);
  const LabelMap filled = With(labels, FillHolesTool(labels, 1, silent));
  EXPECT_EQ((*filled.voxels)[Middle(g)], 1);
  const LabelMap repaired = With(filled, KeepLargestTool(filled, 1, silent));
  EXPECT_EQ((*repaired.voxels)[g.Offset(1, 1, 1)], 0);
  EXPECT_EQ(KeepLargestTool(filled, 0, silent), *repaired.voxels);
  EXPECT_TRUE(CheckLabels(repaired, silent).empty());
  EXPECT_EQ(*repaired.voxels, *Ball(Grid(), 9).voxels);
}

TEST(LabelTools, NoFindingsOnACleanBallAndBorderIsSaid) {
  EXPECT_TRUE(CheckLabels(Ball(Grid(), 8), silent).empty());
  const auto findings = CheckLabels(Ball(Grid(), 40), silent);
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_EQ(findings[0].kind, LabelFinding::Kind::Border);
  EXPECT_EQ(CheckLabels(Ball(Grid(), 0.01, 7), silent)[0].kind, LabelFinding::Kind::Empty);
}

TEST(LabelTools, SmallIslandsGoLargeOnesStay) {
  LabelMap labels = Ball(Grid(), 6);
  LabelVoxels voxels = *labels.voxels;
  voxels[labels.grid.Offset(0, 0, 0)] = 1;
  labels = With(labels, voxels);
  const LabelVoxels kept = RemoveIslandsTool(labels, 1, 0.1, silent);
  EXPECT_EQ(kept[0], 0);
  EXPECT_EQ(CountOf(kept, 1) + 1, CountOf(voxels, 1));
  EXPECT_EQ(RemoveIslandsTool(labels, 1, 0.0, silent), voxels);
}

TEST(LabelTools, SmoothingRemovesSpikesAndKeepsTheVolume) {
  LabelMap labels = Ball(Grid(40), 14);
  LabelVoxels voxels = *labels.voxels;
  const std::size_t spike = labels.grid.Offset(2, 2, 2);
  voxels[spike] = 1;
  labels = With(labels, voxels);
  const LabelVoxels smooth = SmoothTool(labels, 1, 2.5, silent);
  EXPECT_EQ(smooth[spike], 0);
  EXPECT_NEAR(double(CountOf(smooth, 1)) / double(CountOf(voxels, 1)), 1.0, 0.04);
}

TEST(LabelTools, ThresholdRespectsWhereItMayPaint) {
  const LabelMap labels = Ball(Grid(), 8);
  Volume ct;
  ct.grid = labels.grid;
  ct.voxels = std::make_shared<std::vector<std::int16_t>>(ct.grid.VoxelCount(), 120);
  const LabelVoxels inside = ThresholdTool(ct, labels, 3, 100, 200, 1, silent);
  EXPECT_EQ(CountOf(inside, 3), CountOf(*labels.voxels, 1));
  EXPECT_EQ(CountOf(inside, 0), CountOf(*labels.voxels, 0));
  EXPECT_EQ(ThresholdTool(ct, labels, 3, 121, 200, -1, silent), *labels.voxels);
}

TEST(LabelTools, GrowingStopsAtTheEdgeAndRefusesSeedsOutside) {
  const LabelMap ball = Ball(Grid(), 8);
  Volume ct;
  ct.grid = ball.grid;
  auto hu = std::make_shared<std::vector<std::int16_t>>(ct.grid.VoxelCount(), -100);
  for (std::size_t v = 0; v < hu->size(); ++v)
    if ((*ball.voxels)[v]) (*hu)[v] = 150;
  ct.voxels = hu;
  const LabelMap empty = With(ball, LabelVoxels(ball.voxels->size(), 0));
  const Eigen::Vector3i seed = ct.grid.size / 2;
  EXPECT_EQ(GrowTool(ct, empty, 1, seed, 40, 100, silent), *ball.voxels);
  const LabelVoxels near = GrowTool(ct, empty, 1, seed, 40, 4, silent);
  EXPECT_LT(CountOf(near, 1), CountOf(*ball.voxels, 1));
  EXPECT_THROW(GrowTool(ct, empty, 1, {-1, 3, 3}, 40, 100, silent), InputError);
}

TEST(LabelTools, MarginIsTheExactDistance) {
  const LabelMap labels = Ball(Grid(), 4, 2);
  const GridGeometry& g = labels.grid;
  const auto mask = MarginVoxels(labels, 2, 3.2, silent);
  std::vector<Vec3> tumour;
  for (int k = 0; k < g.size[2]; ++k)
    for (int j = 0; j < g.size[1]; ++j)
      for (int i = 0; i < g.size[0]; ++i)
        if ((*labels.voxels)[g.Offset(i, j, k)] == 2)
          tumour.push_back(Vec3(i, j, k).cwiseProduct(g.spacing_mm));
  for (int k = 0; k < g.size[2]; ++k)
    for (int j = 0; j < g.size[1]; ++j)
      for (int i = 0; i < g.size[0]; ++i) {
        double nearest = 1e9;
        for (const Vec3& t : tumour)
          nearest = std::min(nearest, (Vec3(i, j, k).cwiseProduct(g.spacing_mm) - t).norm());
        if (std::abs(nearest - 3.2) < 1e-4) continue;
        EXPECT_EQ(bool(mask[g.Offset(i, j, k)]), nearest > 0 && nearest < 3.2) << i << j << k;
      }
}

TEST(LabelTools, Booleans) {
  LabelMap labels = Ball(Grid(30), 10);
  LabelVoxels voxels = *labels.voxels;
  const LabelMap core = Ball(Grid(30), 4, 2);
  for (std::size_t v = 0; v < voxels.size(); ++v)
    if ((*core.voxels)[v]) voxels[v] = 2;
  labels = With(labels, voxels);
  const auto add = BooleanTool(labels, 1, 2, BooleanOperation::Add, 0, silent);
  EXPECT_EQ(CountOf(add, 2), 0u);
  EXPECT_EQ(CountOf(add, 1), CountOf(voxels, 1) + CountOf(voxels, 2));
  const auto less = BooleanTool(labels, 1, 2, BooleanOperation::Subtract, 3, silent);
  const auto near = BooleanTool(labels, 1, 2, BooleanOperation::Intersect, 3, silent);
  EXPECT_EQ(CountOf(less, 1) + CountOf(near, 1), CountOf(voxels, 1));
  EXPECT_GT(CountOf(near, 1), 0u);
  EXPECT_EQ(CountOf(less, 2), CountOf(voxels, 2));
}

TEST(LabelTools, ImportedLabelsAreResampledAndStrangersRefused) {
  const LabelMap labels = Ball(Grid(), 7, 5);
  GridGeometry finer = labels.grid;
  finer.size = {48, 52, 42};
  finer.spacing_mm *= 0.5;
  const LabelVoxels out = MapLabels(labels, {{5, 1}}, finer, silent);
  const double before = double(CountOf(*labels.voxels, 5)) * labels.grid.VoxelVolume_mm3();
  EXPECT_NEAR(double(CountOf(out, 1)) * finer.VoxelVolume_mm3() / before, 1.0, 0.02);
  EXPECT_THROW(MapLabels(labels, {{4, 1}}, finer, silent), InputError);
  finer.origin_mm += Vec3(500, 0, 0);
  EXPECT_THROW(MapLabels(labels, {{5, 1}}, finer, silent), InputError);
}

TEST(LabelTools, CancelIsHonoured) {
  class Stop : public Progress {
    bool IsCancelled() const override { return true; }
  } stop;
  const LabelMap labels = Ball(Grid(), 7);
  EXPECT_THROW(SmoothTool(labels, 1, 3, stop), Cancelled);
  EXPECT_THROW(KeepLargestTool(labels, 1, stop), Cancelled);
  EXPECT_THROW(MarginVoxels(labels, 1, 3, stop), Cancelled);
}

}  // namespace kerf
