#pragma once

#include <ctime>
#include <optional>
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

/// When the camera was calibrated, as its file says it (`calibration_time`: ISO 8601, or as
/// OpenCV's calibration writes it); empty where it does not. A copy is as old as what it is a copy
/// of.
/// @throws InputError
std::string ReadCalibrationTime(const std::string& path);

/// @param time as ReadCalibrationTime gives it @return whole days up to `now`, negative for a time
/// that is a day or more ahead; none for a text that is no date
std::optional<int> CalibrationAge_days(const std::string& time, std::time_t now);

/// Writes the camera with camera_from_world (LPS), atomically.
/// @param calibrated when it was, as ReadCalibrationTime gives it; empty: not known
/// @throws InputError
void WriteCameraFile(const std::string& path, const CameraModel& camera,
                     const std::string& calibrated = {});

}  // namespace kerf
