#pragma once

#include <string>

#include "Adapters/Itk/VolumeFiles.h"
#include "Adapters/OpenCv/CameraFile.h"
#include "CaseIO/StudyFolder.h"
#include "Pipelines/PlanPipeline.h"

namespace kerf::testing {

/// Plans a study as Planning does and writes its case. @return `case_folder`
inline std::string PlanStudyCase(const std::string& study_folder, const std::string& case_folder,
                                 int tetrahedra) {
  const Study study = OpenStudy(study_folder);
  MeshingOptions meshing;
  meshing.tetrahedra = tetrahedra;
  Progress silent;
  PlannedCase planned = PlanFromLabels(ReadLabelMap(study.labels), meshing, silent);
  planned.camera = ReadCameraFile(study.camera);
  planned.landmarks = ReadCaseLandmarks(study.landmarks);
  WriteCase(planned, case_folder, {{"input", "labels.nii.gz"}});
  return case_folder;
}

}  // namespace kerf::testing
