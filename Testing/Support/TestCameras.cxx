#include "Support/TestCameras.h"

namespace kerf::testing {

CameraModel Pinhole(int width, int height, double focal_px, const Vec3& origin_in_camera) {
  CameraModel camera;
  camera.width = width;
  camera.height = height;
  camera.fx = camera.fy = focal_px;
  camera.cx = 0.5 * (width - 1);
  camera.cy = 0.5 * (height - 1);
  camera.camera_from_world.translation() = origin_in_camera;
  return camera;
}

CameraModel PinholeAbove(int width, int height, double focal_px, double distance_mm) {
  CameraModel camera = Pinhole(width, height, focal_px, Vec3(0, 0, distance_mm));
  camera.camera_from_world.linear() = Vec3(1, -1, -1).asDiagonal();
  return camera;
}

CameraModel Laparoscope(const Eigen::Isometry3d& camera_from_world) {
  CameraModel camera = Pinhole(960, 540, 905);
  camera.fy = 906.81;
  camera.cx = 484;
  camera.cy = 266;
  camera.distortion = {-0.165, 0.052, 6e-4, -4e-4, 0};
  camera.camera_from_world = camera_from_world;
  return camera;
}

}  // namespace kerf::testing
