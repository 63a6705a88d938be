#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "CaseIO/Markups.h"
#include "CaseIO/ResultsFiles.h"
#include "Core/Camera.h"
#include "Core/Frame.h"
#include "Core/TetMesh.h"

namespace kerf {

/// A landmark of the case and where the surgeon saw it.
struct ExposureLandmark {
  std::string name;
  Vec3 rest = Vec3::Zero();   ///< LPS, mm
  std::optional<Vec2> pixel;  ///< raw distorted px
  bool excluded = false;      ///< by the surgeon
  bool outlier = false;       ///< contradicts the others
  double residual_px = std::numeric_limits<double>::quiet_NaN();
  double residual_mm = std::numeric_limits<double>::quiet_NaN();
};

/// The initial registration while the surgeon works on it: given, by landmarks, by hand, by the
/// organ's contour, in any order; each way starts from where the one before ended. Toolkit-free for
/// its users.
class ExposureRegistration {
 public:
  /// @param intrinsics its pose is not used; @param given pose of a camera file, where there is one
  ExposureRegistration(const CameraModel& intrinsics, const TetMesh& mesh,
                       const std::vector<MarkupPoint>& landmarks,
                       const std::optional<Eigen::Isometry3d>& given);

  const CameraModel& Camera() const { return camera_; }
  const SurfaceMesh& Organ() const { return organ_; }  ///< at rest
  bool HasGiven() const { return given_.has_value(); }
  void UseGiven();

  const std::vector<ExposureLandmark>& Landmarks() const { return landmarks_; }
  /// First landmark without a place, −1 when all are placed.
  int NextLandmark() const;
  /// Places it and solves as soon as four are there.
  void Place(int landmark, const Vec2& pixel);
  void Remove(int landmark);
  void Exclude(int landmark, bool excluded);
  /// What the landmarks say about themselves: how many more, an outlier, ambiguity. Empty when all
  /// is well.
  const std::string& LandmarkAdvice() const { return advice_; }

  // By hand. Pixels as seen, raw image.
  void Drag(const Vec2& from, const Vec2& to);  ///< the organ follows across the line of sight
  void Turn(const Vec2& by_px);                 ///< about the organ's centre, like a ball
  void Roll(double degrees);
  void Approach(double factor);  ///< distance from the camera, 0.9: nearer by a tenth

  /// The organ's outline as the surgeon traces it; it takes the place of the one found by colour.
  /// @param outline N×2 raw px, closed by itself; fewer than three points: by colour again
  void Trace(const Pixels& outline);
  bool IsTraced() const { return !traced_.data.empty(); }
  /// Agreement of the model's silhouette with the organ as it is seen: intersection over union.
  double ContourFit(const Frame& frame) const;
  /// Moves the model so that its outline meets the organ's outline. @return agreement afterwards
  double RefineByContour(const Frame& frame);

  bool CanUndo() const { return !history_.empty(); }
  void Undo();
  /// Ways that led here, in order, with residuals: for the journal.
  JournalData Description() const;

 private:
  void Remember(const std::string& way);
  void SolveLandmarks();
  /// The organ in the picture, as traced or by colour.
  Image Seen(const Frame& frame, const Image& model) const;

  CameraModel camera_;
  TetMesh mesh_;
  SurfaceMesh organ_;
  Vec3 center_ = Vec3::Zero();
  std::optional<Eigen::Isometry3d> given_;
  std::vector<ExposureLandmark> landmarks_;
  Image traced_;  ///< empty: by colour
  std::string advice_;
  double rms_px_ = std::numeric_limits<double>::quiet_NaN();
  struct Before {
    Eigen::Isometry3d pose;
    std::vector<ExposureLandmark> landmarks;
    std::string advice;
    std::size_t ways;
  };
  std::vector<Before> history_;
  std::vector<std::string> ways_;
};

}  // namespace kerf
