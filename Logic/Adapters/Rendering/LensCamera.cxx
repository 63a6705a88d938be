#include "Adapters/Rendering/LensCamera.h"

#include <vtkCamera.h>
#include <vtkMath.h>
#include <vtkNew.h>
#include <vtkTransform.h>

#include <cmath>

namespace kerf {

void SetLensCamera(const CameraModel& lens, double near_mm, double far_mm, vtkCamera* camera) {
  const Vec3 center = lens.Center(), ahead = center + lens.ViewDirection();
  const Vec3 up = -lens.camera_from_world.linear().transpose().col(1);
  camera->ParallelProjectionOff();
  camera->SetPosition(center.data());
  camera->SetFocalPoint(ahead.data());
  camera->SetViewUp(up.data());
  camera->SetViewAngle(vtkMath::DegreesFromRadians(2.0 * std::atan(0.5 * lens.height / lens.fy)));
  // The user transform acts after the projection, so it scales the shift of the centre too.
  const double stretch = lens.fx / lens.fy;
  camera->SetWindowCenter(-2.0 * (lens.cx - 0.5 * (lens.width - 1)) / (lens.width * stretch),
                          2.0 * (lens.cy - 0.5 * (lens.height - 1)) / lens.height);
  vtkNew<vtkTransform> aspect;
  aspect->Scale(stretch, 1.0, 1.0);
  camera->SetUserTransform(aspect);
  camera->SetClippingRange(near_mm, far_mm);
}

LensDistortion::LensDistortion(const CameraModel& lens) : lens_(lens), radius_limit_(10.0) {
  const auto& d = lens.distortion;
  for (double r = 0.0; r < 10.0; r += 0.005) {
    const double r2 = r * r;
    const double slope = 1.0 + r2 * (3.0 * d[0] + r2 * (5.0 * d[1] + r2 * 7.0 * d[4]));
    if (slope < 0.1) {
      radius_limit_ = r;
      break;
    }
  }
}

Vec3 LensDistortion::Apply(const Vec3& p) const {
  if (p.z() <= 0) return p;
  const Vec2 n(p.x() / p.z(), p.y() / p.z());
  const double r = n.norm();
  const Vec2 inside = r > radius_limit_ ? Vec2(n * (radius_limit_ / r)) : n;
  const Vec2 pixel = lens_.Distort(inside);
  const Vec2 bent((pixel.x() - lens_.cx) / lens_.fx, (pixel.y() - lens_.cy) / lens_.fy);
  const Vec2 result = bent + (n - inside);
  return {result.x() * p.z(), result.y() * p.z(), p.z()};
}

CameraModel LensDistortion::IdealPinhole() const {
  CameraModel ideal = lens_;
  ideal.distortion = {0, 0, 0, 0, 0};
  ideal.camera_from_world = Eigen::Isometry3d::Identity();
  return ideal;
}

}  // namespace kerf
