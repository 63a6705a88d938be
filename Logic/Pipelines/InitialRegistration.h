#pragma once

#include <string>
#include <vector>

#include "CaseIO/ResultsFiles.h"
#include "CaseIO/StudyFolder.h"
#include "Core/Camera.h"
#include "Core/Progress.h"
#include "Core/TetMesh.h"
#include "Pipelines/ReplayPipeline.h"

namespace kerf {

/// The study's camera with its initial pose: as given, or from landmarks.
/// @param accepted for the journal; @param fits of each landmark, in the file's order
/// @throws InputError
CameraModel InitialCamera(const ReplayRequest& request, const Study& study, Progress& progress,
                          JournalData* accepted, std::vector<LandmarkFit>* fits);

/// Where the first picture of `video` shows the organ's outline elsewhere than the pose of `camera`
/// has it, the pose follows the outline (Registration/OutlinePose.h), and a warning says by how
/// much. A pose that agrees with it is not touched: it is better than the outline can say.
void RefineByOutline(const std::string& video, const TetMesh& mesh, Progress& progress,
                     CameraModel* camera, JournalData* accepted);

}  // namespace kerf
