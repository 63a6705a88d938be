#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "Evaluation/CutComparison.h"

namespace kerf {

/// The measures of one frame by name. Names, in the order of the tables: dice, lateral_mean,
/// lateral_max, feature_mean, feature_max, organ_mean, organ_max, internal_mean, internal_max,
/// tumour_mean, tumour_max. A measure that the frame does not have is absent. Distances in mm.
struct FrameScores {
  int frame = 0;
  std::map<std::string, double> values;
  int feature_count = 0;
};

/// Names of the measures in the order of the tables.
const std::vector<std::string>& MeasureNames();

/// Mean over frames, and the worst (smallest Dice, largest distance).
struct MeasureSummary {
  double mean = 0.0, worst = 0.0;
};

/// What a run is worth against the truth of its study.
struct Scores {
  std::string study;
  std::vector<FrameScores> frames;             ///< ascending
  std::map<std::string, double> final_values;  ///< of the last frame
  std::map<std::string, MeasureSummary> over_frames;
  CutComparison cuts;
};

/// Fills final_values and over_frames from `frames`.
void Summarize(Scores* scores);

/// `--require` of evaluate: "dice=0.95" (at least), "feature_mean=2" (at most), also "missed",
/// "false".
struct Requirement {
  std::string measure;
  double limit = 0.0;
};
/// "dice=0.95,organ_mean=2". @throws UsageError naming the part that is not understood
std::vector<Requirement> ParseRequirements(const std::string& text);
/// One sentence for each requirement that is not met (a missing measure is not met). Applies to the
/// last frame.
std::vector<std::string> UnmetRequirements(const Scores& scores,
                                           const std::vector<Requirement>& requirements);

}  // namespace kerf
