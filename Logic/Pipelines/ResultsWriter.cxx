#include "Pipelines/ResultsWriter.h"

#include <filesystem>

#include "Adapters/OpenCv/CameraFile.h"
#include "Adapters/Vtk/MeshFiles.h"
#include "Core/Errors.h"
#include "Registration/CutLine.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;

/// Makes the folder and removes what an earlier run left there and this one might not write again.
std::string PrepareFolder(const std::string& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw InputError(folder, "", "cannot be made: " + error.message());
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    const bool mesh = name.rfind("frame_", 0) == 0 || name.rfind("cut_", 0) == 0 ||
                      name.find("_final.vt") != std::string::npos;
    const bool late = name == "overlay.mp4" || name == "report.html" || name == "metrics.json";
    if (entry.is_regular_file() && (mesh || late)) fs::remove(entry.path(), error);
  }
  if (error) throw InputError(folder, "", "cannot be read: " + error.message());
  return folder;
}

SurfaceMesh Current(const Structure& structure, const RegistrationState& state) {
  return {structure.embedding.Positions(state.positions, state.mesh.tets),
          structure.rest.triangles};
}

}  // namespace

ResultsWriter::ResultsWriter(const std::string& folder, const CameraModel& camera,
                             SurfaceMesh uncut)
    : folder_(PrepareFolder(folder)),
      camera_(camera),
      uncut_(uncut),
      journal_(Path("journal.jsonl")),
      features_(Path("features.csv")) {
  WriteCameraFile(Path("camera.yml"), camera);
}

const ResultsWriter::OrganView& ResultsWriter::View(const RegistrationState& state) {
  if (view_tets_ != state.mesh.TetCount() || view_vertices_ != state.mesh.VertexCount()) {
    view_tets_ = state.mesh.TetCount();
    view_vertices_ = state.mesh.VertexCount();
    const SurfaceMesh rest = BoundarySurface(state.mesh, state.mesh.rest, &vertex_of_point_);
    view_.rest = rest.points;
    view_.current.triangles = rest.triangles;
    view_.cut_face = state.cuts.empty() ? std::vector<std::uint8_t>(rest.triangles.rows(), 0)
                                        : CutFaceFlags(rest, uncut_);
  }
  view_.current.points.resize(vertex_of_point_.size(), 3);
  for (std::size_t i = 0; i < vertex_of_point_.size(); ++i)
    view_.current.points.row(i) = state.positions.row(vertex_of_point_[i]);
  return view_;
}

Points ResultsWriter::SurfaceLine(const ModelCut& cut) const {
  return LineOnSurface(cut.line, cut.direction, uncut_);
}

void ResultsWriter::AddFrame(const SessionFrame& frame, const RegistrationState& state,
                             double capture_ms, double render_ms) {
  features_.Add(frame.frame, state.features,
                state.bound.embedding.Positions(state.positions, state.mesh.tets),
                state.bound.rest);
  const Reliability& r = frame.reliability;
  reliability_.push_back(
      {frame.frame, frame.time_s, ToString(r.state), r.score, r.reason, r.tumour_u95_mm});
  fit_.push_back({frame.time_s, r.residual_mm, r.local_misfit_mm});
  const StageTimes& t = frame.times;
  timing_.push_back({frame.frame, capture_ms, t.tracking_ms, t.targets_ms, t.detection_ms,
                     t.cutting_ms, t.solve_ms, t.structures_ms, render_ms,
                     capture_ms + t.Sum() + render_ms});
  if (gate_ != ToString(r.state)) {
    gate_ = ToString(r.state);
    journal_.Write(frame.time_s, frame.frame, "gate",
                   {{"state", gate_}, {"reason", r.reason}, {"score", r.score}});
  }
  for (const CutEvent& event : frame.step.cuts) {
    const std::vector<double> point{event.point.x(), event.point.y(), event.point.z()};
    if (event.first)
      journal_.Write(frame.time_s, frame.frame, "cut proposed",
                     {{"cut", event.cut},
                      {"point_rest_mm", point},
                      {"confidence", state.cuts[event.cut].confidence}});
    journal_.Write(frame.time_s, frame.frame, event.report.done ? "cut applied" : "cut refused",
                   {{"cut", event.cut},
                    {"point_rest_mm", point},
                    {"reason", event.report.reason},
                    {"new_vertices", int(event.report.new_vertices)},
                    {"new_tetrahedra", int(event.report.new_tets)},
                    {"components", event.report.components},
                    {"smallest_dihedral_deg", event.report.smallest_dihedral_deg}});
  }
}

void ResultsWriter::WriteMeshes(const SessionFrame& frame, const RegistrationState& state) {
  const OrganView& view = View(state);
  WriteSurface(view.current, Path(FrameFileName(frame.frame, "organ", "vtp")), Space::LPS,
               &view.rest);
  for (const Structure& structure : state.structures)
    WriteSurface(Current(structure, state),
                 Path(FrameFileName(frame.frame, structure.name, "vtp")));
}

void ResultsWriter::Finish(const RegistrationState& state) {
  features_.Finish();
  WriteReliabilityFile(Path("reliability.csv"), reliability_);
  WriteTimingFile(Path("timing.csv"), timing_);
  for (std::size_t i = 0; i < state.cuts.size(); ++i) {
    const ModelCut& cut = state.cuts[i];
    if (cut.surface.triangles.rows() == 0) continue;
    cuts_.push_back({cut.detected_frame, SurfaceLine(cut), cut.depth_mm, cut.confidence});
    WriteSurface({cut.surface.points, cut.surface.triangles},
                 Path("cut_" + std::to_string(i) + "_surface.vtp"));
  }
  WriteCutsFile(Path("cuts.json"), cuts_);
  WriteTetMesh(state.mesh, state.positions, Path("organ_final.vtu"));
  for (const Structure& structure : state.structures)
    WriteSurface(Current(structure, state), Path(structure.name + "_final.vtp"));
}

}  // namespace kerf
