#pragma once

#include <string>

#include "Core/Progress.h"
#include "Evaluation/Scores.h"
#include "Pipelines/ReplayPipeline.h"

namespace kerf {

/// What `kerf demo` made and found.
struct DemoResult {
  std::string study, case_folder, results;  ///< folders below the output
  std::string overlay;                      ///< overlay.mp4; empty where nothing could be drawn
  std::string report;                       ///< report.html
  int tetrahedra = 0;
  ReplayResult replay;
  Scores scores;
};

/// The whole of Kerf on a synthetic patient: phantom → plan by segmentation of its CT (the given
/// labels are not used) → replay from the video → evaluation against the truth. Everything below
/// `output`; an older demo there is replaced.
/// @throws UsageError when `output` holds something else; InputError; Cancelled
DemoResult RunDemo(const std::string& output, Progress& progress);

}  // namespace kerf
