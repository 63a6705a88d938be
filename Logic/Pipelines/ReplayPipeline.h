#pragma once

#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "Core/Progress.h"
#include "Registration/MethodOptions.h"
#include "Registration/Reliability.h"

namespace kerf {

struct ReportData;

/// `kerf replay`: the whole intraoperative job over a recorded study.
struct ReplayRequest {
  std::string study;                       ///< study folder
  std::string results;                     ///< output folder
  std::optional<std::string> case_folder;  ///< planned before; none = plan into results/case
  enum class Labels { Automatic, Given, Segment } labels = Labels::Automatic;
  std::optional<std::string> tracks;  ///< perfect tracks instead of the video
  enum class InitialPose { Given, Landmarks } registration = InitialPose::Given;
  bool outline = true;  ///< an initial pose that contradicts the organ's outline is moved
  std::optional<int> tetrahedra;
  int threads = 0;
  /// Report: only the pictures of report.html, a handful. Video: overlay.mp4 too.
  enum class Drawing { None, Report, Video } drawing = Drawing::Video;
  std::set<std::string>
      given;  ///< options of the method that the user gave: they win over the study's suggestions
  MethodOptions method;
};

/// How an initial registration from landmarks fits one of them.
struct LandmarkFit {
  int id = 0;
  double residual_px = 0.0, residual_mm = 0.0;
  bool outlier = false;  ///< contradicts the others
};

struct ReplayResult {
  std::vector<LandmarkFit> landmarks;  ///< in the file's order; empty with the given pose
  int frames = 0;
  int cuts = 0;
  GateState final_gate = GateState::Off;
  std::string final_reason;
  std::optional<std::string>
      broken;  ///< the video broke in the middle: where and why; everything before it is kept
  double median_ms = 0.0, p99_ms = 0.0;  ///< of the pipeline without capture and rendering
  /// What report.html was made of, pictures included: written again with the scores by those who
  /// know the truth.
  std::shared_ptr<ReportData> report;
};

/// Writes the results folder of DESIGN §3. Deterministic for every thread count.
/// @throws InputError, UsageError, Cancelled
ReplayResult Replay(const ReplayRequest& request, Progress& progress);

}  // namespace kerf
