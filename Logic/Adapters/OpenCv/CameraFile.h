#pragma once

#include <string>

#include "Core/Camera.h"

namespace kerf {

/// Reads an OpenCV FileStorage camera: image_width, image_height, camera_matrix (3×3),
/// distortion_coefficients (up to 5, none = 0) and the pose: camera_from_world (4×4, LPS) or, where
/// that is missing, T_cam_from_ct (4×4, RAS).
/// @throws InputError naming file and key: missing matrix, wrong size, not a number, skewed axes,
/// no rigid transform
CameraModel ReadCameraFile(const std::string& path);

/// Only the intrinsics: a file without a pose is accepted (camera_from_world = identity), as
/// calibration writes it.
CameraModel ReadCameraIntrinsics(const std::string& path);

/// A study's camera has a pose, a calibration need not have one. @throws InputError
bool CameraFileHasPose(const std::string& path);

/// Writes the camera with camera_from_world (LPS), atomically. @throws InputError
void WriteCameraFile(const std::string& path, const CameraModel& camera);

}  // namespace kerf
