#include "PlanningFiles.h"

#include <filesystem>

#include "Adapters/Itk/VolumeFiles.h"
#include "Adapters/OpenCv/CameraFile.h"
#include "CaseIO/CaseFolder.h"
#include "CaseIO/InputHash.h"
#include "CaseIO/ResultsFiles.h"
#include "Core/Errors.h"
#include "Pipelines/PlanPipeline.h"
#include "Session/ResectionFiles.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;

/// What planning adds to the case that `kerf plan` would write.
void WritePlan(const CaseToSave& what, const std::string& folder) {
  CaseWriter writer = CaseWriter::Update(folder);
  writer.Remove("preview.png");
  StageResectionPlan(what.plan, &writer);
  if (!what.preview.isNull())
    what.preview.save(QString::fromStdString(writer.Stage("preview.png", "preview")));
  writer.Commit();
}

/// What its file says, or nothing: the work is saved whatever has become of that file.
std::string CalibratedAt(const std::string& camera_file) {
  try {
    return camera_file.empty() ? std::string() : ReadCalibrationTime(camera_file);
  } catch (const InputError&) {
    return {};
  }
}

}  // namespace

std::shared_ptr<const PlannedCase> MeshLabels(const LabelMap& labels, int tetrahedra,
                                              Progress& progress) {
  MeshingOptions options;
  options.tetrahedra = tetrahedra;
  auto planned = std::make_shared<PlannedCase>(PlanFromLabels(labels, options, progress));
  planned->provenance["tetrahedra_wanted"] = std::to_string(tetrahedra);
  return planned;
}

std::shared_ptr<const PlanningModel> ModelOf(const PlannedCase& planned) {
  auto model = std::make_shared<PlanningModel>();
  model->mesh = planned.mesh;
  model->organ_surface = planned.organ_surface;
  model->structures = planned.structures;
  model->input_volume_mm3 = planned.report.input_volume_mm3;
  model->edge_mm = planned.report.edge_mm;
  model->quality = planned.report.quality;
  model->points_outside = planned.embedding.outside;
  model->farthest_outside_mm = planned.embedding.largest_distance_mm;
  if (const SurfaceMesh* tumour = model->Find("tumour"))
    model->organ_to_tumour_mm = DistancesTo(*tumour, model->organ_surface.points);
  return model;
}

void SaveCase(const CaseToSave& what, const std::string& folder, Progress& progress) {
  progress.Report(0.05, "naming the input");
  PlannedCase planned = *what.planned;
  planned.ct = what.ct;
  planned.labels = what.labels;
  planned.camera = what.camera;
  planned.calibrated = CalibratedAt(what.camera_path);
  planned.landmarks = what.landmarks;
  planned.seeds = what.seeds;
  // As `kerf plan` names its input: by its content, so that the same CT has the same pseudonym.
  if (fs::exists(what.ct_path))
    planned.provenance["input_sha256"] = Sha256OfInput(what.ct_path, progress);
  progress.ThrowIfCancelled();
  progress.Report(0.3, "writing the case");
  WriteCase(planned, folder, {{"program", std::string("kerf ") + KERF_VERSION}});
  progress.Report(0.9, "writing the plan");
  WritePlan(what, folder);
  progress.Report(1.0, "saved");
}

OpenedCase ReadCaseForPlanning(const std::string& folder, Progress& progress) {
  progress.Report(0.0, "checking the case");
  const CaseFolder opened = CaseFolder::Open(folder);
  if (!opened.Has("ct") || !opened.Has("segmentation"))
    throw UsageError(folder +
                     ": this case has no CT or no segmentation, there is nothing to plan on. It "
                     "can be used in the operating room.");
  OpenedCase result;
  progress.Report(0.2, "reading the CT");
  result.ct = ReadVolume(opened.Path("ct"), {}, progress);
  progress.ThrowIfCancelled();
  progress.Report(0.5, "reading the segmentation");
  LabelMap labels = ReadLabelMap(opened.Path("segmentation"));
  labels.voxels = std::make_shared<const LabelVoxels>(
      MapLabels(labels, {{1, 1}, {2, 2}, {3, 3}}, result.ct.grid, progress));
  labels.grid = result.ct.grid;
  result.labels = CountLabels(std::move(labels));
  progress.Report(0.8, "reading the meshes");
  auto planned = std::make_shared<PlannedCase>(ReadCase(folder));
  planned->report.input_volume_mm3 = planned->report.quality.volume_mm3;
  result.rest.landmarks = planned->landmarks;
  result.rest.camera = planned->camera;
  if (planned->camera) result.rest.camera_path = opened.Path("camera");
  result.rest.plan = ReadResectionPlan(opened);
  for (const std::string& path : opened.Paths("plan"))
    if (fs::path(path).filename() == "seeds.mrk.json")
      for (const MarkupList& list : ReadMarkups(path))
        result.rest.seeds.insert(result.rest.seeds.end(), list.points.begin(), list.points.end());
  result.rest.folder = folder;
  result.rest.dirty = false;
  result.planned = planned;
  result.model = ModelOf(*planned);
  return result;
}

}  // namespace kerf
