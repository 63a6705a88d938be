#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "CaseIO/ResultsFiles.h"
#include "Core/Frame.h"
#include "Core/TetMesh.h"
#include "Evaluation/Scores.h"

namespace kerf {

/// A picture for the report, with the overlay on it.
struct ReportSnapshot {
  int frame = 0;  ///< −1: none that was registered
  double time_s = 0.0;
  Image image;
};

/// How well the model fits one frame, mm at the model's depth.
struct ReportFit {
  double time_s = 0.0;
  double residual_mm = 0.0;      ///< median of the tracked features
  double local_misfit_mm = 0.0;  ///< in the neighbourhood where it is largest
};

/// All that report.html of a replay shows. Whatever is empty is left out.
struct ReportData {
  std::string study, method;              ///< "kidney-1", "kerf"
  std::vector<std::string> warnings;      ///< a video that broke, features that ran out …
  std::vector<ReportSnapshot> snapshots;  ///< in the order of time
  std::vector<TimingRow> timing;
  std::vector<ReliabilityRow> reliability;
  std::vector<ReportFit> fit;
  std::vector<CutRecord> cuts;
  bool cutting = true;  ///< false: detection was switched off
  std::optional<MeshQuality> planned_mesh, final_mesh;
  std::vector<std::pair<std::string, std::string>> parameters, versions;
  std::optional<Scores> scores;  ///< against a truth, where one was given
};

/// The sentences at the head of the report: trust, cuts, accuracy or speed.
std::vector<std::string> KeySentences(const ReportData& data);

/// Self-contained HTML: picture and key sentences first, then the figures.
/// @throws InputError naming the file when it can't be written
void WriteReport(const std::string& path, const ReportData& data);

}  // namespace kerf
