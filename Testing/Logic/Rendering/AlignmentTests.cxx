// Does the overlay lie where the lens says? Known points through VTK and through OpenCV.

#include <gtest/gtest.h>
#include <vtkCamera.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>

#include <opencv2/calib3d.hpp>
#include <vector>

#include "Adapters/Rendering/GeometryBuffers.h"
#include "Adapters/Rendering/LensCamera.h"
#include "Adapters/Rendering/VirtualDisplay.h"
#include "SceneFixtures.h"

namespace kerf {
namespace {

using testing::Sphere;
using testing::StrongLens;

Vec2 ThroughOpenCv(const CameraModel& lens, const Vec3& world) {
  const cv::Matx33d k(lens.fx, 0, lens.cx, 0, lens.fy, lens.cy, 0, 0, 1);
  const auto& r = lens.camera_from_world;
  cv::Matx33d rotation;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) rotation(i, j) = r.linear()(i, j);
  cv::Mat rvec;
  cv::Rodrigues(rotation, rvec);
  const cv::Vec3d t(r.translation().x(), r.translation().y(), r.translation().z());
  const std::vector<double> distortion(lens.distortion.begin(), lens.distortion.end());
  std::vector<cv::Point2d> out;
  cv::projectPoints(std::vector<cv::Point3d>{{world.x(), world.y(), world.z()}}, rvec, t, k,
                    distortion, out);
  return {out[0].x, out[0].y};
}

// Pixel where a VTK camera of this lens's size puts a point (continuous, centre of the upper left
// pixel = 0).
Vec2 ThroughVtkMatrix(vtkCamera* camera, const CameraModel& lens, const Vec3& world) {
  vtkMatrix4x4* m =
      camera->GetCompositeProjectionTransformMatrix(double(lens.width) / lens.height, -1, 1);
  const double in[4] = {world.x(), world.y(), world.z(), 1};
  double out[4];
  m->MultiplyPoint(in, out);
  return {0.5 * (out[0] / out[3] + 1) * lens.width - 0.5,
          0.5 * (1 - out[1] / out[3]) * lens.height - 0.5};
}

// Pixels spread over the image, its corners included.
std::vector<Vec2> Spread(const CameraModel& lens) {
  std::vector<Vec2> pixels;
  for (double u : {12.0, 240.0, 480.0, 720.0, lens.width - 13.0})
    for (double v : {12.0, 150.0, 300.0, lens.height - 13.0}) pixels.push_back({u, v});
  return pixels;
}

TEST(LensCamera, PinholeAgreesWithOpenCvToRoundOff) {
  CameraModel lens = StrongLens();
  const std::vector<Vec2> pixels = Spread(lens);
  lens.distortion = {0, 0, 0, 0, 0};
  vtkNew<vtkCamera> camera;
  SetLensCamera(lens, 20, 400, camera);
  for (const Vec2& pixel : pixels) {
    const Vec3 world = lens.PointAtDepth(pixel, 130);
    EXPECT_LT((ThroughVtkMatrix(camera, lens, world) - ThroughOpenCv(lens, world)).norm(), 1e-6);
  }
}

TEST(LensCamera, BentPointsAgreeWithOpenCvDistortionToRoundOff) {
  const CameraModel lens = StrongLens();
  const LensDistortion distortion(lens);
  vtkNew<vtkCamera> camera;
  const CameraModel ideal = distortion.IdealPinhole();
  SetLensCamera(ideal, 20, 400, camera);
  for (const Vec2& pixel : Spread(lens)) {
    const Vec3 world = lens.PointAtDepth(pixel, 130);
    const Vec3 bent = distortion.Apply(lens.camera_from_world * world);
    EXPECT_LT((ThroughVtkMatrix(camera, ideal, bent) - ThroughOpenCv(lens, world)).norm(), 1e-6);
  }
}

TEST(LensCamera, WithoutTheShiftForPixelCentresItWouldBeHalfAPixelOff) {
  CameraModel lens = StrongLens(), shifted = lens;
  lens.distortion = shifted.distortion = {0, 0, 0, 0, 0};
  shifted.cx += 0.5;
  shifted.cy += 0.5;
  vtkNew<vtkCamera> camera;
  SetLensCamera(shifted, 20, 400, camera);
  const Vec3 world = lens.PointAtDepth({300, 200}, 130);
  EXPECT_GT((ThroughVtkMatrix(camera, lens, world) - ThroughOpenCv(lens, world)).norm(), 0.6);
}

TEST(LensDistortion, PointsFarOutsideAreNotFoldedBackIntoThePicture) {
  CameraModel lens = StrongLens();
  lens.distortion = {-0.4, 0, 0, 0, 0};  // r(1 − 0.4 r²) turns back at r = 0.91
  const LensDistortion distortion(lens);
  double before = 0;
  for (double r = 0.1; r < 4.0; r += 0.1) {
    const double x = distortion.Apply(Vec3(r * 100, 0, 100)).x();
    EXPECT_GT(x, before) << "at r = " << r;
    before = x;
  }
}

class Buffers : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string why;
    if (!RenderingAvailable(&why)) GTEST_SKIP() << why;
  }
};

TEST_F(Buffers, SmallSpheresAppearWhereOpenCvProjectsThem) {
  const CameraModel lens = StrongLens();
  GeometryBuffers buffers(lens);
  for (const Vec2& pixel : Spread(lens)) {
    const Vec3 world = lens.PointAtDepth(pixel, 130);
    const SurfaceMesh ball = Sphere(world, Vec3::Constant(1.2), 3);
    buffers.Render({}, {{&ball, GeometryBuffers::Tumour, nullptr}});
    Vec2 sum = Vec2::Zero();
    double count = 0;
    const GeometryBuffer& seen = buffers.Inside();
    for (int y = 0; y < seen.height; ++y)
      for (int x = 0; x < seen.width; ++x)
        if (seen.surface[std::size_t(y) * seen.width + x] == GeometryBuffers::Tumour) {
          sum += Vec2(x, y);
          ++count;
        }
    ASSERT_GT(count, 40) << "at " << pixel.transpose();
    // The image of a ball is an ellipse whose centre is not quite the image of its centre: compare
    // with the mean of the outline, projected by OpenCV from the tangent circle.
    const Vec3 eye = lens.Center(), axis = (world - eye).normalized();
    const double distance = (world - eye).norm(), sine = 1.2 / distance;
    const Vec3 u = axis.unitOrthogonal(), v = axis.cross(u);
    const double rho = 1.2 * std::sqrt(1 - sine * sine);
    std::vector<Vec2> outline;
    for (int k = 0; k < 180; ++k) {
      const double a = 2 * M_PI * k / 180;
      outline.push_back(ThroughOpenCv(
          lens, world - axis * (1.2 * sine) + rho * (std::cos(a) * u + std::sin(a) * v)));
    }
    double area = 0;
    Vec2 centroid = Vec2::Zero();
    for (int k = 0; k < 180; ++k) {
      const Vec2 &a = outline[k], &b = outline[(k + 1) % 180];
      const double cross = a.x() * b.y() - b.x() * a.y();
      area += cross / 2;
      centroid += (a + b) * cross / 6;
    }
    EXPECT_LT((sum / count - centroid / area).norm(), 0.2) << "at " << pixel.transpose();
  }
}

TEST_F(Buffers, DepthAndFacingAreThoseOfTheSurface) {
  const CameraModel lens = StrongLens();
  const Vec3 world = lens.PointAtDepth({480, 270}, 150);
  const SurfaceMesh ball = Sphere(world, Vec3::Constant(25), 5);
  GeometryBuffers buffers(lens);
  buffers.Render({{&ball, GeometryBuffers::Outer, nullptr}}, {});
  const std::size_t i = std::size_t(270) * lens.width + 480;
  EXPECT_EQ(buffers.Front().surface[i], GeometryBuffers::Outer);
  EXPECT_EQ(buffers.Inside().surface[i], GeometryBuffers::Nothing);
  const Ray ray = lens.RayThrough({480, 270});
  const double z = lens.Depth(ray.origin + ray.direction * ((world - ray.origin).norm() - 25));
  EXPECT_NEAR(buffers.Front().depth_mm[i], z, 0.05);
  EXPECT_GT(buffers.Front().facing[i], 250);
}

TEST_F(Buffers, TheNearerSurfaceHidesTheFarther) {
  const CameraModel lens = StrongLens();
  const SurfaceMesh near = Sphere(lens.PointAtDepth({500, 250}, 120), Vec3::Constant(4)),
                    far = Sphere(lens.PointAtDepth({500, 250}, 150), Vec3::Constant(15));
  GeometryBuffers buffers(lens);
  buffers.Render(
      {}, {{&far, GeometryBuffers::Internal, nullptr}, {&near, GeometryBuffers::Tumour, nullptr}});
  const GeometryBuffer& seen = buffers.Inside();
  EXPECT_EQ(seen.surface[std::size_t(250) * lens.width + 500], GeometryBuffers::Tumour);
  EXPECT_EQ(seen.surface[std::size_t(250) * lens.width + 540], GeometryBuffers::Internal);
}

TEST_F(Buffers, ASurfaceAroundTheCameraDoesNotBreakThePicture) {
  const CameraModel lens = StrongLens();
  const SurfaceMesh around = Sphere(lens.Center(), Vec3::Constant(60));
  GeometryBuffers buffers(lens);
  buffers.Render({{&around, GeometryBuffers::Outer, nullptr}}, {});
  for (const std::size_t i : {std::size_t(0), buffers.Front().surface.size() / 2})
    EXPECT_EQ(buffers.Front().surface[i], GeometryBuffers::Outer);
}

}  // namespace
}  // namespace kerf
