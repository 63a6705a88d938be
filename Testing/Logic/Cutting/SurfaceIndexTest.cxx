#include <gtest/gtest.h>

#include <random>

#include "Cutting/SurfaceIndex.h"
#include "Support/Draws.h"
#include "Support/TestMeshes.h"

namespace kerf::testing {
namespace {

TEST(SurfaceIndex, ClosestPointAndBorderOfARectangle) {
  const SurfaceIndex index(RectangleCut({0, 0, 0}, {10, 0, 0}, {0, 10, 0}, 7, 9));
  const SurfaceNear inside = index.Closest({3.3, 4.4, 2}, 100);
  EXPECT_NEAR(inside.distance_mm, 2, 1e-12);
  EXPECT_FALSE(inside.on_border);
  const SurfaceNear beyond = index.Closest({13, 4.4, 4}, 100);
  EXPECT_NEAR(beyond.distance_mm, 5, 1e-12);
  EXPECT_TRUE(beyond.on_border);
  EXPECT_EQ(index.Closest({13, 4.4, 4}, 4.9).triangle, -1);
}

TEST(SurfaceIndex, EqualPointsOfASoupAreOne) {
  CutSurface soup;
  soup.points.resize(6, 3);
  soup.points << 0, 0, 0, 10, 0, 0, 10, 10, 0, 0, 0, 0, 10, 10, 0, 0, 10, 0;
  soup.triangles.resize(2, 3);
  soup.triangles << 0, 1, 2, 3, 4, 5;
  EXPECT_FALSE(SurfaceIndex(soup).Closest({5, 5, 1}, 10).on_border);
}

TEST(SurfaceIndex, NoSegmentSlipsThroughBetweenTriangles) {
  const CutSurface s = RectangleCut({0, 0, 0}, {10, 0, 0}, {0, 10, 0}, 5, 5);
  const SurfaceIndex index(s);
  std::mt19937 random(7);
  std::vector<double> hits;
  for (int i = 0; i < 2000; ++i) {
    const Vec2 in_plane = DrawVec2([&] { return double(random() % 1000) / 100 + 0.001; });
    Vec3 p(in_plane.x(), in_plane.y(), 0);
    if (i % 2) p = s.points.row(random() % s.points.rows()).transpose();  // exactly at corners
    const Vec2 slope = DrawVec2([&] { return double(random() % 100) / 50 - 1; });
    const Vec3 d(slope.x(), slope.y(), 1);
    index.Crossings(p - 0.3 * d, p + 0.7 * d, &hits);
    ASSERT_EQ(hits.size(), 1u);
    EXPECT_NEAR(hits[0], 0.3, 1e-9);
  }
}

}  // namespace
}  // namespace kerf::testing
