#pragma once

#include <string>
#include <vector>

#include "Core/Camera.h"
#include "Core/Types.h"

namespace kerf {

/// Pose from anatomical landmarks, with what the surgeon needs to judge it.
struct LandmarkResult {
  CameraModel camera;           ///< the given intrinsics with the pose found
  Eigen::VectorXd residual_px;  ///< N, distance of projected landmark and given pixel
  Eigen::VectorXd residual_mm;  ///< N, the same at the landmark's depth, across the line of sight
  Eigen::VectorXd weight;       ///< N, robust weight of the last iteration, 0..1
  std::vector<Index> outliers;  ///< rows that contradict the others, worst first
  double rms_px = 0.0;          ///< over the landmarks that are no outliers
  bool ambiguous = false;  ///< another, clearly different pose explains the landmarks about as well
  double ambiguity_deg = 0.0;  ///< how far that other pose is turned from the one returned
  std::string
      warning;  ///< a sentence for people about outliers or ambiguity; empty when all is well
};

/// Perspective-n-point from landmarks known in the CT and in the image: minimal solutions (P3P)
/// over all (or, beyond 14 landmarks, a fixed sample of) triples and EPnP/SQPnP on all give the
/// starts; the best are refined on all landmarks by Levenberg–Marquardt with robust (Geman–McClure)
/// weights whose scale comes from the residuals.
/// @param world N×3, patient LPS, mm; @param pixels N×2, raw distorted px, same rows
/// @param intrinsics focal lengths, centre, distortion, size; its pose is not used
/// @param source for messages
/// @throws InputError naming the landmark: fewer than four, row counts differ, not a number, twice
/// the same place,
///   collinear; no pose with the landmarks in front of the camera
LandmarkResult RegisterLandmarks(const Points& world, const Pixels& pixels,
                                 const CameraModel& intrinsics,
                                 const std::string& source = "landmarks");

}  // namespace kerf
