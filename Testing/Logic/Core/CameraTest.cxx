#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "Core/Camera.h"
#include "Core/Errors.h"
#include "Support/TestCameras.h"

namespace kerf {
namespace {

CameraModel Laparoscope() {
  CameraModel camera = testing::Laparoscope(Eigen::Translation3d(5, -8, 150) *
                                            Eigen::AngleAxisd(1.1, Vec3(1, -2, 0.5).normalized()));
  camera.distortion[4] = 0.01;
  return camera;
}

TEST(Camera, PrincipalPointLooksAlongTheAxis) {
  const CameraModel camera = Laparoscope();
  const Ray ray = camera.RayThrough({camera.cx, camera.cy});
  EXPECT_LT((ray.direction - camera.ViewDirection()).norm(), 1e-12);
  EXPECT_LT(
      (camera.Project(camera.Center() + 77.0 * camera.ViewDirection()) - Vec2(camera.cx, camera.cy))
          .norm(),
      1e-9);
}

TEST(Camera, UndistortionInvertsDistortionOverTheWholeImage) {
  const CameraModel camera = Laparoscope();
  for (double u = 0; u <= 959; u += 95.9)
    for (double v = 0; v <= 539; v += 53.9)
      EXPECT_LT((camera.Distort(camera.Undistort({u, v})) - Vec2(u, v)).norm(), 1e-8) << u << v;
}

TEST(Camera, ProjectionAndDepthGiveThePointBack) {
  const CameraModel camera = Laparoscope();
  for (double u = 10; u < 960; u += 150)
    for (double z : {60.0, 150.0, 400.0}) {
      const Vec2 pixel(u, 0.5 * u);
      const Vec3 world = camera.PointAtDepth(pixel, z);
      EXPECT_NEAR(camera.Depth(world), z, 1e-9);
      EXPECT_LT((camera.Project(world) - pixel).norm(), 1e-7);
      const Ray ray = camera.RayThrough(pixel);
      EXPECT_LT((world - ray.origin).cross(ray.direction).norm(), 1e-7) << "not on its ray";
      EXPECT_GT((world - ray.origin).dot(ray.direction), 0.0);
      EXPECT_NEAR(ray.direction.norm(), 1.0, 1e-12);
    }
}

/// k1 alone, computed by hand: x = 0.2, y = 0.1, r² = 0.05, factor 1 + 0.3·0.05 = 1.015.
TEST(Camera, DistortionOfAKnownPoint) {
  CameraModel camera;
  camera.fx = camera.fy = 100;
  camera.distortion = {0.3, 0, 0, 0, 0};
  EXPECT_LT((camera.Distort({0.2, 0.1}) - Vec2(20.3, 10.15)).norm(), 1e-12);
  camera.distortion = {0, 0, 0.01, 0.02, 0};
  // p1: 2xy, r² + 2y²; p2: r² + 2x², 2xy.
  EXPECT_LT((camera.Distort({0.2, 0.1}) -
             100 * Vec2(0.2 + 0.01 * 0.04 + 0.02 * 0.13, 0.1 + 0.01 * 0.07 + 0.02 * 0.04))
                .norm(),
            1e-12);
}

TEST(Camera, BehindIsNowhere) {
  const CameraModel camera = Laparoscope();
  EXPECT_TRUE(std::isnan(camera.Project(camera.Center() - camera.ViewDirection()).x()));
}

TEST(Camera, PixelCentresAreIntegers) {
  const CameraModel camera = Laparoscope();
  EXPECT_TRUE(camera.InImage({0, 0}));
  EXPECT_TRUE(camera.InImage({959, 539}));
  EXPECT_FALSE(camera.InImage({959.5, 539}));
  EXPECT_FALSE(camera.InImage({4, 100}, 5));
}

TEST(Camera, ValidationNamesTheElement) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  auto message = [](const CameraModel& camera) -> std::string {
    try {
      camera.Validate("camera.yml");
    } catch (const InputError& e) {
      return e.what();
    }
    return {};
  };
  EXPECT_EQ(message(Laparoscope()), "");
  CameraModel c = Laparoscope();
  c.width = 0;
  EXPECT_THAT(message(c), ::testing::HasSubstr("camera.yml: image size"));
  c = Laparoscope();
  c.fx = nan;
  EXPECT_THAT(message(c), ::testing::HasSubstr("camera_matrix"));
  c = Laparoscope();
  c.distortion[4] = nan;
  EXPECT_THAT(message(c), ::testing::HasSubstr("distortion"));
  c = Laparoscope();
  c.camera_from_world.linear() *= -1.0;
  EXPECT_THAT(message(c), ::testing::HasSubstr("rigid"));
}

}  // namespace
}  // namespace kerf
