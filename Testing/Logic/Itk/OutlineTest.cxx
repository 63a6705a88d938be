/// Outlines from noisy intensities with partial volumes, against the shapes they were made from.
#include <gtest/gtest.h>

#include <functional>
#include <random>

#include "Adapters/Itk/Outline.h"
#include "Overlap.h"

namespace kerf {
namespace {

constexpr double kParenchyma = 110, kNoise = 20;

GridGeometry Grid() {
  GridGeometry grid;
  grid.size = Eigen::Vector3i(56, 48, 40);
  grid.spacing_mm = Vec3(0.95, 0.95, 1.25);
  grid.origin_mm = Vec3(-26, -22, -25);
  return grid;
}

/// Distance-like function of a shape, mm: negative inside.
using Shape = std::function<double(const Vec3&)>;

Shape Ball(const Vec3& center, double radius) {
  return [=](const Vec3& p) { return (p - center).norm() - radius; };
}

/// Along x from `begin` to `end`, radius falling from `thick` to `thin`.
Shape Taper(double begin, double end, double thick, double thin) {
  return [=](const Vec3& p) {
    const double t = std::clamp((p[0] - begin) / (end - begin), 0., 1.);
    return std::hypot(std::hypot(p[1], p[2]), p[0] - (begin + t * (end - begin))) -
           (thick + t * (thin - thick));
  };
}

template <class F>
void ForEachVoxel(const GridGeometry& grid, F f) {
  std::size_t at = 0;
  for (int k = 0; k < grid.size[2]; ++k)
    for (int j = 0; j < grid.size[1]; ++j)
      for (int i = 0; i < grid.size[0]; ++i, ++at) f(at, Vec3(i, j, k));
}

double Coverage(const GridGeometry& grid, const Vec3& index, const Shape& shape) {
  int inside = 0;
  for (int c = 0; c < 27; ++c)
    inside +=
        shape(grid.WorldFromIndex(index + Vec3(c % 3 - 1, c / 3 % 3 - 1, c / 9 - 1) / 3.)) < 0;
  return inside / 27.;
}

Mask Voxels(const Shape& shape) {
  Mask mask(Grid(), 0);
  ForEachVoxel(mask.grid, [&](std::size_t at, const Vec3& index) {
    mask.values[at] = Coverage(mask.grid, index, shape) > 0.5;
  });
  return mask;
}

/// Parenchyma everywhere, shapes in it in turn, each with its own HU.
ScalarField Scan(const std::vector<std::pair<Shape, double>>& shapes) {
  ScalarField hu(Grid(), 0.f);
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0, kNoise);
  ForEachVoxel(hu.grid, [&](std::size_t at, const Vec3& index) {
    double value = kParenchyma;
    for (const auto& [shape, own] : shapes) {
      const double part = Coverage(hu.grid, index, shape);
      value += part * (own - value);
    }
    hu.values[at] = float(value + noise(random));
  });
  return hu;
}

Mask Everywhere() { return Voxels(Ball(Vec3::Zero(), 24)); }

TEST(Outline, ABallKeepsItsSizeAndTouchesWhatItTouches) {
  const Shape tumour = Ball(Vec3::Zero(), 8), contrast = Ball(Vec3(12, 0, 0), 4.2);
  const ScalarField hu = Scan({{tumour, 60}, {contrast, 900}});
  const Mask truth = Voxels(tumour), other = Voxels(contrast);
  const Mask found = OutlineCompact(hu, Voxels(Ball(Vec3::Zero(), 6.5)), Everywhere(), other);
  EXPECT_GT(
      testing::Dice(
          found.values, truth.values, [](int v) { return v > 0; }, [](int v) { return v > 0; }),
      0.95);
  EXPECT_NEAR(Volume_ml(found) / Volume_ml(truth), 1, 0.04);
  // Between the two lie voxels as bright as parenchyma that are half tumour, half contrast agent.
  std::size_t lost = 0, contact = 0;
  ForEachVoxel(found.grid, [&](std::size_t at, const Vec3& index) {
    const Vec3 p = found.grid.WorldFromIndex(index);
    if (!truth.values[at] || other.values[at] || contrast(p) > 1.5) return;
    ++contact;
    lost += !found.values[at];
  });
  EXPECT_GT(contact, 20u);
  EXPECT_LT(lost, contact / 10);
}

TEST(Outline, AVesselKeepsItsVolumeAndItsThinEnd) {
  const Shape vessel = Taper(-16, 14, 2.6, 0.7);
  const ScalarField hu = Scan({{vessel, 200}});
  const Mask truth = Voxels(vessel);
  const Mask found = OutlineBranching(hu, Voxels(Taper(-16, 0, 2.3, 1.4)), Everywhere());
  EXPECT_NEAR(Volume_ml(found) / Volume_ml(truth), 1, 0.12);
  double farthest = -100;
  std::size_t false_ones = 0;
  ForEachVoxel(found.grid, [&](std::size_t at, const Vec3& index) {
    if (!found.values[at]) return;
    const Vec3 p = found.grid.WorldFromIndex(index);
    farthest = std::max(farthest, p[0]);
    false_ones += vessel(p) > 1.5;
  });
  EXPECT_GT(farthest, 11) << "the end of half a voxel's thickness is at 14.7";
  EXPECT_LE(false_ones, 3u);
}

TEST(Outline, AVesselThatEndsIsNotFollowed) {
  const Shape vessel = Taper(-16, 0, 2.6, 2.2);
  const Mask found =
      OutlineBranching(Scan({{vessel, 200}}), Voxels(Taper(-16, 0, 2.2, 1.8)), Everywhere());
  ForEachVoxel(found.grid, [&](std::size_t at, const Vec3& index) {
    if (found.values[at]) {
      EXPECT_LT(vessel(found.grid.WorldFromIndex(index)), 2.0);
    }
  });
}

TEST(Outline, WhatNoiseDoesNotMoveStaysAsItIs) {
  const Shape calyx = Taper(-16, 0, 3, 2);
  const Mask body = Voxels(calyx);
  EXPECT_EQ(OutlineBranching(Scan({{calyx, 900}}), body, Everywhere()).values, body.values);
  const Mask nothing(Grid(), 0);
  EXPECT_EQ(OutlineBranching(Scan({}), nothing, Everywhere()).values, nothing.values);
  EXPECT_EQ(OutlineCompact(Scan({}), nothing, Everywhere(), nothing).values, nothing.values);
}

}  // namespace
}  // namespace kerf
