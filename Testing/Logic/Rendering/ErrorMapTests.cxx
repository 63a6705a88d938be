#include <gtest/gtest.h>

#include <limits>

#include "Adapters/Rendering/ErrorMap.h"
#include "Adapters/Rendering/VirtualDisplay.h"
#include "Support/TestCameras.h"
#include "Support/TestMeshes.h"

namespace kerf {
namespace {

constexpr int kWidth = 320, kHeight = 200;

class ErrorMap : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string why;
    ASSERT_TRUE(RenderingAvailable(&why)) << why;
  }
  /// @return blue, green, red in the middle of the picture
  static std::array<int, 3> Middle(const Image& image, int dx = 0) {
    const std::size_t at = 3 * (std::size_t(kHeight / 2) * kWidth + kWidth / 2 + dx);
    return {image.data[at], image.data[at + 1], image.data[at + 2]};
  }
  Image Render(const Eigen::VectorXd& error, ErrorMapView view = ErrorMapView::FromCamera) const {
    return RenderErrorMap(surface_, error, 5.0, camera_, view, kWidth, kHeight);
  }
  Eigen::VectorXd Everywhere(double error) const {
    return Eigen::VectorXd::Constant(surface_.points.rows(), error);
  }

  CameraModel camera_ = testing::Pinhole(kWidth, kHeight, 300, Vec3(0, 0, 150));
  TetMesh block_ = testing::BoxMesh(Vec3(60, 30, 12), 6, 3, 2);
  SurfaceMesh surface_ = BoundarySurface(block_, block_.rest);
};

TEST_F(ErrorMap, SmallErrorsArePaleLargeOnesDarkRed) {
  const auto none = Middle(Render(Everywhere(0))), most = Middle(Render(Everywhere(5))),
             beyond = Middle(Render(Everywhere(50)));
  EXPECT_GT(none[1], 180);
  EXPECT_GT(none[2], 180);
  EXPECT_LT(most[1], 40);
  EXPECT_GT(most[2], most[1] + 60) << "red";
  EXPECT_EQ(most, beyond);
}

TEST_F(ErrorMap, EachVertexHasItsColour) {
  const auto left_bad = [&](double sign) {
    Eigen::VectorXd error = Everywhere(0);
    for (Index v = 0; v < error.size(); ++v)
      if (sign * (camera_.camera_from_world * Vec3(surface_.points.row(v))).x() < -1) error[v] = 5;
    return error;
  };
  const Image left = Render(left_bad(1)), right = Render(left_bad(-1));
  EXPECT_LT(Middle(left, -60)[1] + 100, Middle(left, 60)[1]) << "left in the camera's picture";
  EXPECT_LT(Middle(right, 60)[1] + 100, Middle(right, -60)[1]);
}

TEST_F(ErrorMap, TheSideViewLooksAlongTheCamerasXAxis) {
  Eigen::VectorXd error = Everywhere(0);  // bad where the camera's right is
  for (Index v = 0; v < error.size(); ++v)
    if ((camera_.camera_from_world * Vec3(surface_.points.row(v))).x() > 29) error[v] = 5;
  EXPECT_LT(Middle(Render(error, ErrorMapView::FromTheRight))[1], 60);
}

TEST_F(ErrorMap, WhatIsNotKnownIsGrey) {
  const auto unknown = Middle(Render(Everywhere(std::numeric_limits<double>::quiet_NaN())));
  EXPECT_NEAR(unknown[0], unknown[1], 3);
  EXPECT_NEAR(unknown[1], unknown[2], 3);
}

TEST_F(ErrorMap, WrongCountsAreRefused) {
  EXPECT_THROW(Render(Eigen::VectorXd::Zero(3)), std::invalid_argument);
  EXPECT_THROW(RenderErrorMap({}, {}, 5.0, camera_, ErrorMapView::FromCamera, 64, 64),
               std::invalid_argument);
}

}  // namespace
}  // namespace kerf
