#pragma once

#include <map>
#include <optional>
#include <string>

#include "Core/Progress.h"
#include "Evaluation/Scores.h"
#include "Evaluation/SurfaceDistance.h"

namespace kerf {

/// Judges a results folder against the truth of its study (`STUDY/truth`, layout:
/// docs/reference/study-and-results.md). Frames that the results do not have are skipped, with a
/// warning; results may be .vtp, .ply, .stl, .obj or .vtk. Deterministic for every thread count.
/// @throws InputError naming file and element: no truth, none of the frames to be judged; Cancelled
Scores EvaluateAgainstTruth(const std::string& results, const std::string& study,
                            Progress& progress);

/// Final meshes against a second CT: distance to the surfaces of its labels and Dice of volumes, by
/// structure name
/// ("organ" is everything inside the organ's outer surface, "internal", "tumour").
struct ReferenceScores {
  std::map<std::string, DistanceStatistics> distance;
  std::map<std::string, double> volume_dice;
};
/// @param labels_file label map of the second CT (1 organ, 2 tumour, 3 inner structure; or
/// .seg.nrrd)
/// @param transform_file moves the second CT onto the case: 4×4 matrix as text (LPS) or ITK .tfm
/// (LPS, stored from parent as Slicer does, hence inverted); empty = identity
/// @throws InputError; Cancelled
ReferenceScores EvaluateAgainstLabels(const std::string& results, const std::string& labels_file,
                                      const std::string& transform_file, Progress& progress);

/// metrics.json: case, frames, final, over_frames, cuts, and reference where given. Atomic.
void WriteMetricsFile(const std::string& path, const Scores* scores,
                      const ReferenceScores* reference);
std::string MetricsText(const Scores* scores, const ReferenceScores* reference);
/// The final and over_frames part of a metrics.json. @throws InputError
Scores ReadMetricsFile(const std::string& path);

/// The paper's figures as a table for people.
std::string ScoresTable(const Scores& scores);
std::string ReferenceTable(const ReferenceScores& scores);

}  // namespace kerf
