#pragma once

#include "Core/Camera.h"
#include "Core/Frame.h"
#include "Core/SurfaceMesh.h"

namespace kerf {

/// Where the surface is looked at from: along the camera's line of sight, or along its x axis, from
/// the right of its picture, where errors of depth are seen from the side.
enum class ErrorMapView { FromCamera, FromTheRight };

/// A surface coloured by an error: pale where it is small, dark red from `largest_mm` on, with a
/// scale. Parallel projection, the whole surface in the picture.
/// @param error_mm one value a vertex, NaN grey
/// @return BGR image, width × height
/// @throws std::runtime_error where RenderingAvailable() is false; std::invalid_argument when the
/// number of errors differs from that of the vertices or the surface is empty
Image RenderErrorMap(const SurfaceMesh& surface, const Eigen::VectorXd& error_mm, double largest_mm,
                     const CameraModel& camera, ErrorMapView view, int width, int height);

}  // namespace kerf
