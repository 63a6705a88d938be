#pragma once

#include "Core/Camera.h"
#include "Core/Frame.h"
#include "Core/SurfaceMesh.h"

namespace kerf {

/// Projection of a surface into the raw (distorted) image: 1 channel, 255 where a triangle covers
/// the pixel centre.
Image ProjectedMask(const SurfaceMesh& surface, const CameraModel& camera);

}  // namespace kerf
