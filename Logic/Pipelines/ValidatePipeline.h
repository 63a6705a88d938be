#pragma once

#include <optional>
#include <string>
#include <vector>

#include "Core/Progress.h"
#include "Evaluation/Scores.h"
#include "Pipelines/ReplayPipeline.h"

namespace kerf {

/// One way to run a study.
struct ValidationVariant {
  Method method = Method::Kerf;
  bool cutting = true;
  bool perfect_tracks = false;  ///< features_2d.csv instead of the video
  std::string Name() const;     ///< "kerf-video-cut"
};

struct ValidateRequest {
  std::vector<std::string> studies;  ///< with truth; folder names must differ
  std::string output;                ///< OUTPUT/<study>/<variant>/ are results folders
  std::vector<ValidationVariant> variants;
  std::optional<int> tetrahedra;
  int threads = 0;  ///< of all runs together; 0: all cores
  /// Studies that run beside each other; 0: one a core. Figures do not depend on it, times a frame
  /// do.
  int jobs = 0;
  ReplayRequest::Drawing drawing = ReplayRequest::Drawing::Report;
  bool grips = true, outline = true;  ///< as of ReplayRequest
};

/// What became of one run.
struct ValidationRun {
  std::string study;
  ValidationVariant variant;
  std::string results;
  std::string error;  ///< why it failed; empty where it is scored
  ReplayResult replay;
  Scores scores;
};

/// Replay and evaluation of every study in every variant; a run that fails is kept as such and the
/// others go on. A study is planned once. Writes OUTPUT/validation.html (tables, overlays, meshes
/// coloured by their error), validation.md and validation.json, anew after every run.
/// @throws InputError, UsageError before anything runs: a study without truth, two of the same
/// name; Cancelled
std::vector<ValidationRun> Validate(const ValidateRequest& request, Progress& progress);

}  // namespace kerf
