#include "Core/Camera.h"

#include <cmath>
#include <limits>

#include "Core/Errors.h"

namespace kerf {

Vec2 CameraModel::Distort(const Vec2& n) const {
  const auto& [k1, k2, p1, p2, k3] = distortion;
  const double x = n.x(), y = n.y(), r2 = x * x + y * y;
  const double radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
  const double xd = x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x);
  const double yd = y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y;
  return {fx * xd + cx, fy * yd + cy};
}

Vec2 CameraModel::Undistort(const Vec2& pixel) const {
  const auto& [k1, k2, p1, p2, k3] = distortion;
  const Vec2 start((pixel.x() - cx) / fx, (pixel.y() - cy) / fy);
  Vec2 n = start;
  for (int i = 0; i < 100; ++i) {
    const double x = n.x(), y = n.y(), r2 = x * x + y * y;
    const double radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
    const Vec2 tangential(2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
                          p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y);
    const Vec2 next = (start - tangential) / radial;
    const double change = (next - n).cwiseAbs().maxCoeff();
    n = next;
    if (change < 1e-12) break;
  }
  return n;
}

Vec2 CameraModel::Project(const Vec3& world) const {
  const Vec3 c = camera_from_world * world;
  if (c.z() <= 1e-6) return Vec2::Constant(std::numeric_limits<double>::quiet_NaN());
  return Distort({c.x() / c.z(), c.y() / c.z()});
}

Ray CameraModel::RayThrough(const Vec2& pixel) const {
  const Vec2 n = Undistort(pixel);
  const Vec3 direction = camera_from_world.linear().transpose() * Vec3(n.x(), n.y(), 1.0);
  return {Center(), direction.normalized()};
}

Vec3 CameraModel::PointAtDepth(const Vec2& pixel, double depth_mm) const {
  const Vec2 n = Undistort(pixel);
  return camera_from_world.inverse() * Vec3(n.x() * depth_mm, n.y() * depth_mm, depth_mm);
}

bool CameraModel::InImage(const Vec2& p, double margin) const {
  return p.x() >= margin && p.y() >= margin && p.x() <= width - 1 - margin &&
         p.y() <= height - 1 - margin;
}

void CameraModel::Validate(const std::string& file) const {
  if (width <= 0 || height <= 0) throw InputError(file, "image size", "must be positive");
  if (!std::isfinite(fx) || !std::isfinite(fy) || fx <= 0 || fy <= 0)
    throw InputError(file, "camera_matrix", "focal lengths must be positive numbers");
  if (!std::isfinite(cx) || !std::isfinite(cy))
    throw InputError(file, "camera_matrix", "principal point is not a number");
  for (double d : distortion)
    if (!std::isfinite(d)) throw InputError(file, "distortion_coefficients", "not a number");
  if (!camera_from_world.matrix().allFinite())
    throw InputError(file, "camera_from_world", "not a number");
  const Mat3 gram = camera_from_world.linear().transpose() * camera_from_world.linear();
  if ((gram - Mat3::Identity()).cwiseAbs().maxCoeff() > 1e-3 ||
      camera_from_world.linear().determinant() < 0)
    throw InputError(file, "camera_from_world", "is not a rigid transform");
}

}  // namespace kerf
