#include <filesystem>

#include "Adapters/Itk/Segmentation.h"
#include "Adapters/Itk/VolumeFiles.h"
#include "Adapters/OpenCv/CameraFile.h"
#include "Adapters/Vtk/MeshFiles.h"
#include "CaseIO/CaseFolder.h"
#include "CaseIO/InputHash.h"
#include "CaseIO/ResultsFiles.h"
#include "Pipelines/PlanPipeline.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;

/// Labels made on another series are silently wrong: at least nine tenths of them must lie in the
/// CT.
void RequireOverlap(const LabelMap& labels, const Volume& ct, Progress& progress) {
  if (labels.grid.SameAs(ct.grid)) return;
  std::size_t labelled = 0, inside = 0;
  const auto& size = labels.grid.size;
  for (int k = 0; k < size[2]; ++k)
    for (int j = 0; j < size[1]; ++j)
      for (int i = 0; i < size[0]; ++i) {
        const std::uint8_t label = (*labels.voxels)[labels.grid.Offset(i, j, k)];
        if (label < 1 || label > 3) continue;
        ++labelled;
        const Vec3 index = ct.grid.IndexFromWorld(labels.grid.WorldFromIndex(Vec3(i, j, k)));
        inside += (index.array() > -0.5).all() &&
                  (index.array() < ct.grid.size.cast<double>().array() - 0.5).all();
      }
  if (labelled == 0) return;  // said by the mesher
  if (inside == 0)
    throw InputError(
        labels.source, "geometry",
        "the labels do not overlap the CT " + ct.source + " (other patient or series?)");
  if (inside < 0.9 * static_cast<double>(labelled))
    throw InputError(labels.source, "geometry",
                     "only " + std::to_string(100 * inside / labelled) +
                         " % of the labelled voxels lie inside the CT " + ct.source);
  progress.Warn(labels.source + ": the grid of the labels differs from that of the CT");
}

LabelMap Segment(const PlanRequest& request, const Volume& ct, Progress& progress) {
  const bool one_organ = HoldsOneOrgan(ct);
  if (request.preset.empty() && request.seeds_file.empty() && one_organ)
    return SegmentStudyCt(ct, progress);
  SegmentationRequest segmentation;
  if (!request.preset.empty()) {
    segmentation.preset = ParseOrganPreset(request.preset);
  } else if (one_organ) {
    segmentation.preset = AssumePreset(ct, progress);
  } else {
    segmentation.preset = OrganPreset::Liver;
    progress.Warn(request.input +
                  ": may show more than one organ and no --preset is given: the liver is segmented "
                  "(--preset kidney with a seed in the kidney for a kidney)");
  }
  if (!request.seeds_file.empty()) {
    segmentation.seeds = ReadSeeds(request.seeds_file);
    segmentation.seeds_source = request.seeds_file;
    CheckSeedsInside(segmentation.seeds, ct.grid, request.seeds_file);
  }
  return SegmentCt(ct, segmentation, progress);
}

void RequireUsable(const PlanRequest& request, bool surface) {
  const auto refuse = [](bool given, const char* option, const char* why) {
    if (given) throw UsageError(std::string(option) + " cannot be used " + why);
  };
  if (surface) {
    const char* why = "with a surface: there is nothing to segment";
    refuse(!request.labels_file.empty(), "--labels", why);
    refuse(!request.seeds_file.empty(), "--seeds", why);
    refuse(!request.preset.empty(), "--preset", why);
    refuse(!request.series_uid.empty(), "--series", why);
  }
  if (!request.labels_file.empty()) {
    refuse(!request.seeds_file.empty(), "--seeds", "together with --labels");
    refuse(!request.preset.empty(), "--preset", "together with --labels");
  }
  if (!request.preset.empty()) ParseOrganPreset(request.preset);
  if (!request.series_uid.empty() && !fs::is_directory(request.input))
    throw UsageError("--series belongs to a DICOM folder, and " + request.input + " is none");
}

}  // namespace

PlannedCase Plan(const PlanRequest& request, Progress& progress) {
  if (!fs::exists(request.input)) throw InputError(request.input, "", "cannot be opened");
  const bool folder = fs::is_directory(request.input);
  const std::string extension = FileExtension(request.input);
  const bool surface = !folder && IsSurfaceExtension(extension);
  RequireUsable(request, surface);
  // What is quickly read and may be wrong comes before the minutes of work.
  std::optional<CameraModel> camera;
  if (!request.camera_file.empty())
    camera = CameraFileHasPose(request.camera_file) ? ReadCameraFile(request.camera_file)
                                                    : ReadCameraIntrinsics(request.camera_file);
  std::vector<MarkupPoint> landmarks;
  if (!request.landmarks_file.empty()) landmarks = ReadCaseLandmarks(request.landmarks_file);
  if (folder && !FolderFormat(request.input).empty())
    throw InputError(request.input, "case.json",
                     "this is a " + FolderFormat(request.input) +
                         " folder; give its CT or its surface (kerf replay plans studies itself)");
  PlannedCase planned;
  if (surface) {
    SubProgress meshing(progress, 0.0, 1.0);
    planned = PlanFromSurface(ReadSurface(request.input), request.input, request.meshing, meshing);
  } else {
    progress.Report(0.0, "reading the CT");
    VolumeReadOptions options;
    options.series = request.series_uid;
    SubProgress reading(progress, 0.0, 0.1), segmenting(progress, 0.1, 0.5),
        meshing(progress, 0.5, 1.0);
    const Volume ct = ReadVolume(request.input, options, reading);
    progress.ThrowIfCancelled();
    LabelMap labels;
    if (request.labels_file.empty()) {
      labels = Segment(request, ct, segmenting);
    } else {
      labels = ReadLabelMap(request.labels_file);
      RequireOverlap(labels, ct, progress);
    }
    planned = PlanFromLabels(labels, request.meshing, meshing);
    planned.ct = ct;
  }
  planned.camera = camera;
  if (camera) planned.calibrated = ReadCalibrationTime(request.camera_file);
  planned.landmarks = std::move(landmarks);
  if (!request.seeds_file.empty())
    for (const MarkupList& list : ReadMarkups(request.seeds_file))
      planned.seeds.insert(planned.seeds.end(), list.points.begin(), list.points.end());
  planned.provenance["input_sha256"] = Sha256OfInput(request.input, progress);
  if (!request.labels_file.empty())
    planned.provenance["labels_sha256"] = Sha256OfFile(request.labels_file);
  if (!request.seeds_file.empty())
    planned.provenance["seeds_sha256"] = Sha256OfFile(request.seeds_file);
  if (!request.preset.empty()) planned.provenance["preset"] = request.preset;
  planned.provenance["tetrahedra_wanted"] = std::to_string(request.meshing.tetrahedra);
  return planned;
}

}  // namespace kerf
