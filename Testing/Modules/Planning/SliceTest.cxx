#include <gtest/gtest.h>

#include "Session/PlanningSlice.h"

namespace kerf {
namespace {

Volume Gradient(const Mat3& direction) {
  Volume ct;
  ct.grid.size = {7, 5, 4};
  ct.grid.spacing_mm = {1, 2, 3};
  ct.grid.direction = direction;
  auto voxels = std::make_shared<std::vector<std::int16_t>>(ct.grid.VoxelCount());
  // The value tells how far left (10), posterior (1) the voxel lies in the patient.
  std::size_t at = 0;
  for (int k = 0; k < 4; ++k)
    for (int j = 0; j < 5; ++j)
      for (int i = 0; i < 7; ++i, ++at) {
        const Vec3 p = ct.grid.WorldFromIndex(Vec3(i, j, k));
        (*voxels)[at] = static_cast<std::int16_t>(std::lround(10 * p[0] + p[1]));
      }
  ct.voxels = std::move(voxels);
  return ct;
}

int Grey(const std::vector<std::uint32_t>& pixels, const SliceFrame& f, int column, int row) {
  return static_cast<int>(pixels[std::size_t(row) * f.columns + column] & 255u);
}

}  // namespace

TEST(Slice, AxialShowsThePatientsRightOnTheLeftAndAnteriorUp) {
  Mat3 flipped = Vec3(-1, -1, 1).asDiagonal();
  for (const Mat3& direction : {Mat3(Mat3::Identity()), flipped}) {
    const Volume ct = Gradient(direction);
    const SliceFrame f = MakeSliceFrame(ct.grid, SlicePlane::Axial);
    EXPECT_EQ(f.left, "R");
    EXPECT_EQ(f.right, "L");
    EXPECT_EQ(f.top, "A");
    EXPECT_EQ(f.bottom, "P");
    std::vector<std::uint32_t> pixels;
    RenderSlice(ct, f, 1, 200, 0, &pixels);
    EXPECT_LT(Grey(pixels, f, 0, 2), Grey(pixels, f, f.columns - 1, 2));  // left is brighter
    EXPECT_LE(Grey(pixels, f, 3, 0), Grey(pixels, f, 3, f.rows - 1));     // posterior is brighter
  }
}

TEST(Slice, CoronalAndSagittalHaveSuperiorUp) {
  const Volume ct = Gradient(Mat3::Identity());
  for (const SlicePlane plane : {SlicePlane::Coronal, SlicePlane::Sagittal}) {
    const SliceFrame f = MakeSliceFrame(ct.grid, plane);
    EXPECT_EQ(f.top, "S");
    EXPECT_EQ(f.bottom, "I");
    EXPECT_GT(ct.grid.WorldFromIndex(f.IndexOf(0, 0, 0))[2],
              ct.grid.WorldFromIndex(f.IndexOf(0, f.rows - 1, 0))[2]);
  }
  EXPECT_EQ(MakeSliceFrame(ct.grid, SlicePlane::Sagittal).left, "A");
  EXPECT_EQ(MakeSliceFrame(ct.grid, SlicePlane::Coronal).left, "R");
}

TEST(Slice, PixelAndIndexAreInverse) {
  Mat3 oblique;
  oblique << 0, 0.1, -1, 1, 0, 0, 0, -1, -0.1;
  const GridGeometry grid = Gradient(oblique).grid;
  for (const SlicePlane plane : {SlicePlane::Axial, SlicePlane::Coronal, SlicePlane::Sagittal}) {
    const SliceFrame f = MakeSliceFrame(grid, plane);
    const Vec3 index(2.25, 3, 1);
    const Vec3 p = f.PixelOf(index);
    EXPECT_LT((f.IndexOf(p[0], p[1], p[2]) - index).norm(), 1e-12);
    EXPECT_EQ(f.columns * f.rows * f.slices, int(grid.VoxelCount()));
  }
}

TEST(Slice, LabelsAreOutlinedAndFilled) {
  Volume ct = Gradient(Mat3::Identity());
  ct.grid.size = {7, 5, 4};
  LabelMap labels;
  labels.grid = ct.grid;
  auto voxels = std::make_shared<std::vector<std::uint8_t>>(ct.grid.VoxelCount(), 0);
  for (int j = 1; j < 4; ++j)
    for (int i = 1; i < 6; ++i) (*voxels)[ct.grid.Offset(i, j, 2)] = 1;
  labels.voxels = voxels;
  std::array<std::uint32_t, 256> colors{};
  colors[1] = 0xffff0000u;
  const SliceFrame f = MakeSliceFrame(ct.grid, SlicePlane::Axial);
  std::vector<std::uint32_t> before, after;
  RenderSlice(ct, f, 2, 200, 0, &before);
  after = before;
  BlendLabels(labels, f, 2, colors, 0.0, &after);
  EXPECT_EQ(after[1 * 7 + 1], 0xffff0000u);
  EXPECT_EQ(after[2 * 7 + 3], before[2 * 7 + 3]);  // inside, no fill
  EXPECT_EQ(after[0], before[0]);
  colors[1] = 0;  // hidden
  after = before;
  BlendLabels(labels, f, 2, colors, 1.0, &after);
  EXPECT_EQ(after, before);
}

}  // namespace kerf
