#include <gtest/gtest.h>

#include <opencv2/calib3d.hpp>
#include <random>

#include "Core/Camera.h"
#include "Support/TestCameras.h"

using namespace kerf;

namespace {

/// Core's camera and OpenCV's have to be the same lens: pixels go through both.
class CameraConsistency : public ::testing::TestWithParam<std::array<double, 5>> {
 protected:
  void SetUp() override {
    camera_ = kerf::testing::Laparoscope(Eigen::Translation3d(7, -5, 130) *
                                         Eigen::AngleAxisd(0.8, Vec3(0.3, -0.9, 0.2).normalized()));
    camera_.distortion = GetParam();
    matrix_ = cv::Matx33d(camera_.fx, 0, camera_.cx, 0, camera_.fy, camera_.cy, 0, 0, 1);
    distortion_.assign(GetParam().begin(), GetParam().end());
  }
  CameraModel camera_;
  cv::Matx33d matrix_;
  std::vector<double> distortion_;
};

TEST_P(CameraConsistency, ProjectsAsOpenCv) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> pixel_u(0, 959), pixel_v(0, 539), depth(80, 250);
  std::vector<cv::Point3d> world;
  std::vector<Vec3> points;
  for (int i = 0; i < 500; ++i) {
    const double u = pixel_u(random), v = pixel_v(random);
    const Vec3 in_camera((u - camera_.cx) / camera_.fx, (v - camera_.cy) / camera_.fy, 1);
    points.push_back(camera_.camera_from_world.inverse() * Vec3(depth(random) * in_camera));
    world.emplace_back(points.back().x(), points.back().y(), points.back().z());
  }
  cv::Matx33d rotation;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) rotation(i, j) = camera_.camera_from_world.linear()(i, j);
  cv::Vec3d rotation_vector;
  cv::Rodrigues(rotation, rotation_vector);
  const Vec3 t = camera_.camera_from_world.translation();
  std::vector<cv::Point2d> projected;
  cv::projectPoints(world, rotation_vector, cv::Vec3d(t.x(), t.y(), t.z()), matrix_, distortion_,
                    projected);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec2 pixel = camera_.Project(points[i]);
    EXPECT_NEAR(pixel.x(), projected[i].x, 1e-6);
    EXPECT_NEAR(pixel.y(), projected[i].y, 1e-6);
  }
}

TEST_P(CameraConsistency, UndistortsAsOpenCv) {
  std::vector<cv::Point2d> pixels;
  for (int v = 0; v < 540; v += 27)
    for (int u = 0; u < 960; u += 48) pixels.emplace_back(u, v);
  // To the same pixel grid, with enough iterations to converge.
  std::vector<cv::Point2d> undistorted;
  cv::undistortPoints(pixels, undistorted, matrix_, distortion_, cv::noArray(), matrix_,
                      {cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 200, 1e-14});
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const Vec2 pixel(pixels[i].x, pixels[i].y);
    const Vec2 normalized = camera_.Undistort(pixel);
    EXPECT_NEAR(normalized.x() * camera_.fx + camera_.cx, undistorted[i].x, 1e-6);
    EXPECT_NEAR(normalized.y() * camera_.fy + camera_.cy, undistorted[i].y, 1e-6);
    EXPECT_LT((camera_.Distort(normalized) - pixel).norm(), 1e-6);
  }
}

INSTANTIATE_TEST_SUITE_P(Lenses, CameraConsistency,
                         ::testing::Values(std::array<double, 5>{0, 0, 0, 0, 0},
                                           std::array<double, 5>{-0.165, 0.052, 6e-4, -4e-4, 0},
                                           std::array<double, 5>{0.08, -0.03, -1e-3, 2e-3, 0.01}));

}  // namespace
