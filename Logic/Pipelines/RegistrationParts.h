#pragma once

#include <memory>
#include <string>

#include "Core/Camera.h"
#include "Core/Features.h"

namespace kerf {

/// The organ as OpenCV's adapter finds it in a video.
std::unique_ptr<OrganSegmenter> MakeVideoOrganSegmenter();

/// @throws InputError when pictures and calibration are of different sizes
void CheckVideoSize(int width, int height, const std::string& video, const CameraModel& camera,
                    const std::string& camera_file);

}  // namespace kerf
