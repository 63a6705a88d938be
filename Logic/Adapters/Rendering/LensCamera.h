#pragma once

#include "Core/Camera.h"
#include "Core/Types.h"

class vtkCamera;

namespace kerf {

/// The one place where a calibrated lens becomes a VTK camera. Pose, focal lengths and principal
/// point are exact (WindowCenter + ViewAngle + UserTransform for fx ≠ fy, so that VTK's lighting
/// stays right); distortion is not a camera's business in VTK: bend the vertices with
/// LensDistortion. The viewport must have the lens's size; pixel centres are at integers as in
/// OpenCV, so the image spans [−0.5, width − 0.5].
/// @param near_mm,far_mm clipping range, 0 < near < far
void SetLensCamera(const CameraModel& lens, double near_mm, double far_mm, vtkCamera* camera);

/// Bends points of the camera frame so that an ideal pinhole with the lens's fx fy cx cy sees them
/// where the distorted lens does: (x, y, z) → (x_d·z, y_d·z, z). Depth is kept, so hidden surfaces
/// stay right. Exact at vertices; between them an edge of 5 mm errs by less than 0.1 px.
class LensDistortion {
 public:
  explicit LensDistortion(const CameraModel& lens);
  /// @param camera_point camera frame, mm; returned as it is when z ≤ 0
  Vec3 Apply(const Vec3& camera_point) const;
  /// Same camera without distortion and with the camera frame as its world.
  CameraModel IdealPinhole() const;

 private:
  CameraModel lens_;
  double radius_limit_;  ///< from here on the polynomial folds back; it is continued as a straight
                         ///< line
};

}  // namespace kerf
