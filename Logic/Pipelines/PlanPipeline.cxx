#include "Pipelines/PlanPipeline.h"

#include <algorithm>
#include <filesystem>

#include "Adapters/Itk/Segmentation.h"
#include "Adapters/Itk/VolumeFiles.h"
#include "Adapters/OpenCv/CameraFile.h"
#include "Adapters/Vtk/LabelMesh.h"
#include "Adapters/Vtk/LabelSurface.h"
#include "Adapters/Vtk/MeshFiles.h"
#include "CaseIO/CaseFolder.h"
#include "CaseIO/ResultsFiles.h"
#include "CaseIO/StudyFolder.h"
#include "Core/Errors.h"

namespace kerf {
namespace {

/// For work whose warnings were already given.
class WithoutWarnings : public SubProgress {
 public:
  using SubProgress::SubProgress;
  void Warn(const std::string&) override {}
};

/// Surface of one label within the organ, bound to the mesh.
void AddStructure(const LabelMap& labels, const std::vector<std::uint8_t>& organ, Label label,
                  const std::string& name, Progress& progress, PlannedCase* planned) {
  std::vector<std::uint8_t> mask(organ.size());
  for (std::size_t v = 0; v < mask.size(); ++v)
    mask[v] = organ[v] && (*labels.voxels)[v] == static_cast<std::uint8_t>(label);
  const LabelField field = SmoothMask(labels.grid, mask);
  if (field.Empty()) return;
  progress.ThrowIfCancelled();
  Structure structure;
  structure.name = name;
  structure.rest = SurfaceOfField(field, labels.source);
  EmbeddingReport report;
  structure.embedding = EmbedPoints(planned->mesh, structure.rest.points, &report);
  planned->embedding.inside += report.inside;
  planned->embedding.outside += report.outside;
  planned->embedding.largest_distance_mm =
      std::max(planned->embedding.largest_distance_mm, report.largest_distance_mm);
  planned->structures.push_back(std::move(structure));
}

void WarnOfUnknownLabels(const LabelMap& labels, Progress& progress) {
  std::array<bool, 256> seen{};
  for (const std::uint8_t v : *labels.voxels) seen[v] = true;
  for (int v = 4; v < 256; ++v)
    if (seen[v])
      progress.Warn(labels.source + ": label " + std::to_string(v) +
                    " is none of 1 (organ), 2 (tumour), 3 (inner structure): left out");
}

}  // namespace

PlannedCase PlanFromLabels(const LabelMap& labels, const MeshingOptions& options,
                           Progress& progress) {
  PlannedCase planned;
  planned.labels = labels;
  WarnOfUnknownLabels(labels, progress);
  SubProgress meshing(progress, 0.0, 0.8);
  planned.mesh = MeshByFilter(labels, options, meshing, &planned.report);
  planned.organ_surface = BoundarySurface(planned.mesh, planned.mesh.rest);
  progress.Report(0.8, "surfaces of the inner structures");
  WithoutWarnings again(progress, 0.8, 0.9);
  const std::vector<std::uint8_t> organ = OrganMask(labels, again);
  AddStructure(labels, organ, Label::Internal, "internal", progress, &planned);
  AddStructure(labels, organ, Label::Tumour, "tumour", progress, &planned);
  progress.Report(1.0, "planned");
  return planned;
}

PlannedCase PlanFromSurface(const SurfaceMesh& surface, const std::string& file,
                            const MeshingOptions& options, Progress& progress) {
  PlannedCase planned;
  planned.mesh = MeshClosedSurface(surface, file, options, progress, &planned.report);
  planned.organ_surface = BoundarySurface(planned.mesh, planned.mesh.rest);
  return planned;
}

void WriteCase(const PlannedCase& planned, const std::string& folder,
               const std::map<std::string, std::string>& provenance) {
  CaseWriter writer(folder);
  auto& manifest = writer.Manifest();
  manifest.provenance = planned.provenance;
  for (const auto& [key, value] : provenance) manifest.provenance[key] = value;
  manifest.provenance["tetrahedra"] = std::to_string(planned.mesh.TetCount());
  WriteTetMesh(planned.mesh, planned.mesh.rest, writer.Stage("organ.vtu", "organ_mesh"));
  WriteSurface(planned.organ_surface, writer.Stage("organ.vtp", "organ_surface"), Space::LPS,
               &planned.organ_surface.points);
  for (const Structure& structure : planned.structures)
    WriteSurface(structure.rest, writer.Stage(structure.name + ".vtp", structure.name), Space::LPS,
                 &structure.rest.points);
  if (planned.labels)
    WriteSegmentation(writer.Stage("segmentation.seg.nrrd", "segmentation"), *planned.labels);
  if (planned.ct) WriteVolume(writer.Stage("ct.nrrd", "ct"), *planned.ct);
  if (!planned.landmarks.empty())
    WriteMarkups(writer.Stage("landmarks.mrk.json", "landmarks"),
                 {{"Fiducial", planned.landmarks}});
  if (!planned.seeds.empty())
    WriteMarkups(writer.Stage("plan/seeds.mrk.json", "plan"), {{"Fiducial", planned.seeds}});
  if (planned.camera)
    WriteCameraFile(writer.Stage("camera.yml", "camera"), *planned.camera, planned.calibrated);
  // From what was planned, not from whom: the same input has the same pseudonym.
  const auto input = manifest.provenance.find("input_sha256");
  manifest.pseudonym = PseudonymFromHash(
      input != manifest.provenance.end() ? input->second
                                         : Sha256OfText(std::to_string(planned.mesh.rest.sum()) +
                                                        std::to_string(planned.mesh.TetCount())));
  writer.Commit();
}

std::vector<MarkupPoint> ReadCaseLandmarks(const std::string& path) {
  std::vector<MarkupPoint> points;
  if (FileExtension(path) == "csv") {
    for (const Landmark& landmark : ReadLandmarks(path))
      points.push_back({"landmark-" + std::to_string(landmark.id), landmark.rest});
  } else {
    for (const MarkupList& list : ReadMarkups(path))
      points.insert(points.end(), list.points.begin(), list.points.end());
  }
  if (points.empty()) throw InputError(path, "", "holds no landmark");
  return points;
}

PlannedCase ReadCase(const std::string& folder) {
  const CaseFolder opened = CaseFolder::Open(folder);
  PlannedCase planned;
  planned.provenance = opened.Manifest().provenance;
  planned.mesh = ReadTetMesh(opened.Path("organ_mesh"));
  planned.report.quality = MeasureQuality(planned.mesh, planned.mesh.rest);
  planned.organ_surface = BoundarySurface(planned.mesh, planned.mesh.rest);
  for (const std::string name : {"internal", "tumour"}) {
    if (!opened.Has(name)) continue;
    Structure structure;
    structure.name = name;
    structure.rest = ReadSurface(opened.Path(name));
    EmbeddingReport report;
    structure.embedding = EmbedPoints(planned.mesh, structure.rest.points, &report);
    planned.embedding.inside += report.inside;
    planned.embedding.outside += report.outside;
    planned.embedding.largest_distance_mm =
        std::max(planned.embedding.largest_distance_mm, report.largest_distance_mm);
    planned.structures.push_back(std::move(structure));
  }
  if (opened.Has("landmarks")) planned.landmarks = ReadCaseLandmarks(opened.Path("landmarks"));
  if (opened.Has("camera")) {
    planned.camera = ReadCameraFile(opened.Path("camera"));
    planned.calibrated = ReadCalibrationTime(opened.Path("camera"));
  }
  return planned;
}

}  // namespace kerf
