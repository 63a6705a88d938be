#pragma once

#include <QImage>
#include <memory>
#include <string>

#include "Core/Progress.h"
#include "Session/PlanningSession.h"

/// Between the session and files: the same code as `kerf plan`.
namespace kerf {

struct PlannedCase;

/// Everything that saving needs, taken on the GUI thread.
struct CaseToSave {
  std::shared_ptr<const PlannedCase> planned;  ///< mesh, surfaces, structures as planned
  Volume ct;
  LabelMap labels;
  std::string ct_path;
  std::vector<MarkupPoint> seeds, landmarks;
  std::optional<CameraModel> camera;
  std::string camera_path;  ///< where it was read; says when it was calibrated
  ResectionPlan plan;
  Points line_on_surface{0, 3};
  QImage preview;
};

/// Label map → mesh, structures, embedding, and what the session shows of it.
std::shared_ptr<const PlannedCase> MeshLabels(const LabelMap& labels, int tetrahedra,
                                              Progress& progress);
std::shared_ptr<const PlanningModel> ModelOf(const PlannedCase& planned);

/// Writes the case folder. @throws InputError, UsageError, Cancelled
void SaveCase(const CaseToSave& what, const std::string& folder, Progress& progress);

/// What a saved case gives back for more planning.
struct OpenedCase {
  Volume ct;
  CountedLabels labels;
  PlanningSession::Restored rest;
  std::shared_ptr<const PlannedCase> planned;
  std::shared_ptr<const PlanningModel> model;
};
/// @throws InputError; UsageError for a case without a CT (planned from a surface)
OpenedCase ReadCaseForPlanning(const std::string& folder, Progress& progress);

}  // namespace kerf
