#pragma once

#include <functional>

#include "Core/Camera.h"
#include "Core/Frame.h"
#include "Core/TetMesh.h"

namespace kerf {

struct OutlinePoseOptions {
  int reach_px = 40;  ///< how far the organ's outline is searched to either side
  /// What is known of the given pose before the picture is looked at, standard deviations per axis.
  /// 0: nothing.
  double turn_deg = 0.0, shift_mm = 0.0;
};

struct OutlinePose {
  Eigen::Isometry3d camera_from_world = Eigen::Isometry3d::Identity();
  /// Of the outline that the picture shows under the given pose; 0: too few, the pose is the given
  /// one.
  Index points = 0;
  double before_px = 0.0, after_px = 0.0;  ///< distance of the outlines, mean of the nearest 3/4
};

/// The organ in the picture, given the model's projection (as OrganSegmenter::Segment).
using SeenOrgan = std::function<Image(const Image& model_mask)>;

/// Rigid registration of an organ at rest by its outline: Gauss-Newton on the distances across the
/// model's outline, robust (Geman-McClure, the scale follows the residuals: what a clamp or other
/// tissue hides is an outlier), with the pose of `camera` as a prior.
OutlinePose FitPoseToOutline(const TetMesh& mesh, const CameraModel& camera, const SeenOrgan& seen,
                             const OutlinePoseOptions& options);

}  // namespace kerf
