#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <stdexcept>

#include "Evaluation/Silhouette.h"
#include "Support/TestCameras.h"
#include "Support/TestMeshes.h"

namespace kerf {
namespace {

CameraModel TestCamera() { return testing::Pinhole(320, 240, 400, Vec3(0, 0, 100)); }

std::size_t Area(const Image& mask) {
  return std::accumulate(mask.data.begin(), mask.data.end(), std::size_t(0)) / 255;
}

SurfaceMesh Quad(double x0, double y0, double x1, double y1) {
  SurfaceMesh s;
  s.points.resize(4, 3);
  s.points << x0, y0, 0, x1, y0, 0, x1, y1, 0, x0, y1, 0;
  s.triangles.resize(2, 3);
  s.triangles << 0, 1, 2, 0, 2, 3;
  return s;
}

TEST(Silhouette, ASquareCoversItsPixels) {
  // 4 px per mm: 20 mm are 80 px; sides run between pixels.
  const Image mask = Silhouette(TestCamera(), Quad(-10, -10, 10, 10));
  EXPECT_NEAR(static_cast<double>(Area(mask)), 6400.0, 2 * 160);
  EXPECT_EQ(mask.data[119 * 320 + 159], 255);
  EXPECT_EQ(mask.data[119 * 320 + 159 - 45], 0);
}

TEST(Silhouette, ASphereHasTheAreaOfItsOutline) {
  const CameraModel camera = TestCamera();
  const Image mask = Silhouette(camera, testing::SphereSurface(Vec3(0, 0, 0), 20.0, 5));
  // Tangent cone: tan of its half angle is r / sqrt(d² − r²).
  const double radius_px = 400.0 * 20.0 / std::sqrt(100.0 * 100.0 - 400.0);
  EXPECT_NEAR(static_cast<double>(Area(mask)) / (M_PI * radius_px * radius_px), 1.0, 0.01);
}

TEST(Silhouette, MovesWithThePrincipalPoint) {
  CameraModel camera = TestCamera();
  const Image a = Silhouette(camera, Quad(-10, -10, 10, 10));
  camera.cx += 7;
  const Image b = Silhouette(camera, Quad(-10, -10, 10, 10));
  for (int y = 0; y < a.height; ++y)
    for (int x = 0; x + 7 < a.width; ++x)
      ASSERT_EQ(a.data[y * a.width + x], b.data[y * a.width + x + 7]) << x << " " << y;
}

TEST(Silhouette, LeavesOutWhatIsBehindTheCameraAndClipsTheRest) {
  EXPECT_EQ(Area(Silhouette(TestCamera(), Quad(-1000, -1000, 1000, 1000))), 320u * 240u);
  CameraModel behind = TestCamera();
  behind.camera_from_world.translation() = Vec3(0, 0, -100);
  EXPECT_EQ(Area(Silhouette(behind, Quad(-10, -10, 10, 10))), 0u);
  EXPECT_EQ(Area(Silhouette(TestCamera(), SurfaceMesh())), 0u);
}

TEST(Dice, OfKnownMasks) {
  Image a{4, 1, 1, {255, 255, 0, 0}}, b{4, 1, 1, {0, 128, 255, 0}}, none{4, 1, 1, {0, 0, 0, 0}};
  EXPECT_DOUBLE_EQ(Dice(a, a), 1.0);
  EXPECT_DOUBLE_EQ(Dice(a, b), 0.5);
  EXPECT_DOUBLE_EQ(Dice(a, none), 0.0);
  EXPECT_DOUBLE_EQ(Dice(none, none), 1.0);
  Image other{2, 2, 1, {0, 0, 0, 0}};
  EXPECT_THROW(Dice(a, other), std::invalid_argument);
}

}  // namespace
}  // namespace kerf
