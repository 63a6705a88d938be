#pragma once

#include "Core/Camera.h"
#include "Core/Frame.h"
#include "Core/SurfaceMesh.h"

namespace kerf {

/// Projection of a surface into the (distorted) image: 255 where at least half of a pixel is
/// covered, else 0. Sampled 4×4 times per pixel; triangles that reach nearer than 1 mm to the
/// camera plane are left out.
/// @return 1 channel, the camera's size
Image Silhouette(const CameraModel& camera, const SurfaceMesh& surface);

/// Dice coefficient 2|A∩B| / (|A|+|B|) of the non-zero pixels; 1 where both are empty.
/// @throws std::invalid_argument when sizes differ or an image has more than one channel
double Dice(const Image& a, const Image& b);

}  // namespace kerf
