#pragma once

#include "Core/Camera.h"

/// Cameras for tests. The principal point of a plain pinhole is the middle of its picture.
namespace kerf::testing {

/// No distortion, axes as the world's; the world's origin is at `origin_in_camera` (mm).
CameraModel Pinhole(int width, int height, double focal_px,
                    const Vec3& origin_in_camera = Vec3::Zero());

/// No distortion; looks down −z at the world's origin from `distance_mm`, x to the right.
CameraModel PinholeAbove(int width, int height, double focal_px, double distance_mm);

/// A laparoscope as it comes out of a calibration: 960 × 540, unequal focal lengths, the principal
/// point beside the middle, barrel distortion.
CameraModel Laparoscope(const Eigen::Isometry3d& camera_from_world = Eigen::Isometry3d::Identity());

}  // namespace kerf::testing
