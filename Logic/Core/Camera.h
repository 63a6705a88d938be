#pragma once

#include <array>
#include <string>

#include "Core/Types.h"

namespace kerf {

/// Half line in world coordinates; direction is a unit vector.
struct Ray {
  Vec3 origin = Vec3::Zero();
  Vec3 direction = Vec3::UnitZ();
};

/// Calibrated pinhole camera with OpenCV's five-parameter distortion (k1 k2 p1 p2 k3).
/// x_camera = camera_from_world · x_world (world = patient LPS, mm; camera x right, y down, z
/// forward).
struct CameraModel {
  int width = 0, height = 0;  ///< px
  double fx = 0, fy = 0, cx = 0, cy = 0;
  std::array<double, 5> distortion{0, 0, 0, 0, 0};
  Eigen::Isometry3d camera_from_world = Eigen::Isometry3d::Identity();

  /// Camera centre and viewing direction (optical axis) in world coordinates.
  Vec3 Center() const { return camera_from_world.inverse().translation(); }
  Vec3 ViewDirection() const { return camera_from_world.linear().transpose().col(2); }

  /// Normalized (undistorted) image coordinates → distorted pixel.
  Vec2 Distort(const Vec2& normalized) const;
  /// Distorted pixel → normalized coordinates (x/z, y/z), by fixed-point iteration to 1e-12.
  Vec2 Undistort(const Vec2& pixel) const;
  /// World point → distorted pixel; points behind the camera give NaN.
  Vec2 Project(const Vec3& world) const;
  double Depth(const Vec3& world) const { return (camera_from_world * world).z(); }
  /// Viewing ray of a distorted pixel.
  Ray RayThrough(const Vec2& pixel) const;
  /// World point on the ray of `pixel` at camera depth z.
  Vec3 PointAtDepth(const Vec2& pixel, double depth_mm) const;
  bool InImage(const Vec2& pixel, double margin_px = 0.0) const;
  /// @throws InputError naming `file`: size, focal lengths, NaN
  void Validate(const std::string& file) const;
};

}  // namespace kerf
