/// Organs that are hardly thicker than what leads away from them, of uneven brightness, and what
/// was found in part.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "Adapters/Itk/OrganRegion.h"
#include "Adapters/Itk/Segmentation.h"
#include "Overlap.h"
#include "TestSupport.h"

namespace kerf {
namespace {

using testing::Listener;
using testing::OrganDice;

constexpr double kBend_mm = 32, kTube_mm = 9;  // radii of the bent body's axis and cross-section

struct Scene {
  Volume ct;
  std::vector<std::uint8_t> truth;
};

Vec3 OnAxis(double degrees) {
  const double angle = degrees * M_PI / 180;
  return kBend_mm * Vec3(std::cos(angle), 0, std::sin(angle));
}

/// Without contrast, 2 × 2 × 3 mm, noise of 16 HU, in fat: a kidney's parenchyma around its sinus
/// as a bent body from −130° to 130°, 30 HU at its lower end and 6 at its upper one.
Scene MakeScene() {
  Scene s;
  auto& grid = s.ct.grid;
  grid.size = Eigen::Vector3i(72, 36, 40);
  grid.spacing_mm = Vec3(2, 2, 3);
  grid.origin_mm = -0.5 * grid.spacing_mm.cwiseProduct((grid.size.cast<double>() - Vec3::Ones()));
  s.ct.source = "scene";
  s.truth.assign(grid.VoxelCount(), 0);
  auto voxels = std::make_shared<std::vector<std::int16_t>>(grid.VoxelCount());
  std::mt19937 random(11);
  std::normal_distribution<double> noise(0, 16);
  std::size_t at = 0;
  for (int k = 0; k < grid.size[2]; ++k)
    for (int j = 0; j < grid.size[1]; ++j)
      for (int i = 0; i < grid.size[0]; ++i, ++at) {
        const Vec3 p = grid.WorldFromIndex(Vec3(i, j, k));
        const double angle = std::clamp(std::atan2(p.z(), p.x()) * 180 / M_PI, -130.0, 130.0);
        double hu = -100;
        if ((p - OnAxis(angle)).norm() < kTube_mm) {
          hu = 30 - 24 * (angle + 130) / 260;
          s.truth[at] = 1;
        }
        (*voxels)[at] = std::int16_t(std::lround(hu + noise(random)));
      }
  s.ct.voxels = voxels;
  return s;
}

LabelMap FromSeed(const Scene& scene, double degrees, Progress& progress,
                  SegmentationReport* report) {
  SegmentationRequest request;
  request.preset = OrganPreset::Kidney;
  request.seeds = {{SeedKind::Organ, OnAxis(degrees), "seed"}};
  return SegmentCt(scene.ct, request, progress, report);
}

TEST(SlenderOrgan, IsFoundWholeFromBothOfItsEnds) {
  const Scene scene = MakeScene();
  for (const double degrees : {-105.0, 0.0, 105.0}) {
    Listener heard;
    SegmentationReport report;
    const LabelMap labels = FromSeed(scene, degrees, heard, &report);
    EXPECT_GT(OrganDice(*labels.voxels, scene.truth), 0.88) << degrees;
    EXPECT_LT(report.open_surface, 0.03) << degrees;
    EXPECT_FALSE(heard.Heard("its own brightness")) << degrees;
  }
}

/// A ball of 20 mm that was found whole, and half of it: its flat side has no edge.
TEST(SlenderOrgan, WhatWasFoundInPartHasAnOpenSurface) {
  GridGeometry grid;
  grid.size = Eigen::Vector3i::Constant(61);
  grid.spacing_mm = Vec3::Ones();
  Mask whole(grid, 0), half(grid, 0);
  std::size_t at = 0;
  for (int k = -30; k <= 30; ++k)
    for (int j = -30; j <= 30; ++j)
      for (int i = -30; i <= 30; ++i, ++at) {
        whole.values[at] = Vec3(i, j, k).norm() < 20;
        half.values[at] = whole.values[at] && k < 0;
      }
  EXPECT_EQ(OpenShare(whole, whole), 0.0);
  // 4 mm out: π·19.6² over the flat side, of that, 2π·24² over the round one and the rim between.
  EXPECT_NEAR(OpenShare(half, whole), 0.21, 0.02);
}

}  // namespace
}  // namespace kerf
