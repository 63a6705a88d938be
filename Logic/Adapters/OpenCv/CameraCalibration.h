#pragma once

#include <string>
#include <vector>

#include "Core/Camera.h"
#include "Core/Progress.h"

namespace kerf {

enum class BoardKind { Chessboard, Charuco };

/// A printed calibration board. Columns and rows count squares, as one counts them on the print.
struct CalibrationBoard {
  BoardKind kind = BoardKind::Chessboard;
  int columns = 0, rows = 0;
  double square_mm = 0.0;
  double marker_mm = 0.0;  ///< side of the markers of a ChArUco board, smaller than a square
  std::string dictionary = "4x4_50";  ///< of a ChArUco board: 4x4_50, 4x4_100, 5x5_100, 6x6_250 …

  /// @throws UsageError: too small, marker not smaller than the square, unknown dictionary
  void Validate() const;
};

/// One picture of the board.
struct CalibrationView {
  std::string file;
  int corners = 0;      ///< found on it
  double rms_px = 0.0;  ///< reprojection error; 0 where it was not used
  std::string problem;  ///< why it was not used; empty when it was
};

struct CalibrationResult {
  CameraModel camera;                  ///< intrinsics and distortion; the pose is the identity
  double rms_px = 0.0;                 ///< over all corners used
  double focal_deviation_px = 0;       ///< standard deviation of the focal length as estimated
  std::vector<CalibrationView> views;  ///< in the order of the files
  std::vector<std::string>
      warnings;  ///< sentences for people: few views, little of the image covered …
};

/// Intrinsics and distortion (k1 k2 p1 p2, and k3 where the pictures show it) from pictures of one
/// board. Pictures on which the board is not found, whose size differs, or which fit far worse than
/// the others are left out and named.
/// @throws InputError when fewer than three pictures can be used or they fit no lens; Cancelled
CalibrationResult CalibrateCamera(const std::vector<std::string>& files,
                                  const CalibrationBoard& board, Progress& progress);

}  // namespace kerf
