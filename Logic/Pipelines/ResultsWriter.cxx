#include "Pipelines/ResultsWriter.h"

#include <filesystem>

#include "Adapters/OpenCv/CameraFile.h"
#include "Adapters/Vtk/MeshFiles.h"
#include "Core/Errors.h"
#include "Session/AppliedCuts.h"
#include "Session/IntraoperativeDecision.h"

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

}  // namespace

ResultsWriter::ResultsWriter(const std::string& folder, const CameraModel& camera,
                             SurfaceMesh uncut, bool features)
    : folder_(PrepareFolder(folder)),
      camera_(camera),
      uncut_(uncut),
      view_(uncut_),
      journal_(Path("journal.jsonl")) {
  if (features) features_.emplace(Path("features.csv"));
  WriteCameraFile(Path("camera.yml"), camera);
}

void ResultsWriter::AddFrame(const SessionFrame& frame, const RegistrationState& state,
                             double capture_ms, double render_ms) {
  if (features_)
    features_->Add(frame.frame, state.features,
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
    if (event.first)
      journal_.Write(frame.time_s, frame.frame, "cut proposed",
                     {{"cut", event.cut},
                      {"point_rest_mm",
                       std::vector<double>{event.point.x(), event.point.y(), event.point.z()}},
                      {"confidence", state.cuts[event.cut].confidence}});
    if (state.cuts[event.cut].held) continue;  // not before it is accepted
    journal_.Write(frame.time_s, frame.frame, EventName(event.report),
                   ToJournal(event.cut, event.point, event.report));
  }
}

void ResultsWriter::WriteMeshes(const SessionFrame& frame, const RegistrationState& state) {
  const OrganView& view = View(state);
  WriteSurface(view.current, Path(FrameFileName(frame.frame, "organ", "vtp")), Space::LPS,
               &view.rest);
  for (const Structure& structure : state.structures)
    WriteSurface(CurrentSurface(structure, state),
                 Path(FrameFileName(frame.frame, structure.name, "vtp")));
}

void ResultsWriter::WriteCuts(const RegistrationState& state) {
  cuts_ = AppliedCuts(state, uncut_);
  WriteCutsFile(Path("cuts.json"), cuts_);
}

void ResultsWriter::Finish(const RegistrationState& state) {
  if (features_) features_->Finish();
  WriteReliabilityFile(Path("reliability.csv"), reliability_);
  WriteTimingFile(Path("timing.csv"), timing_);
  WriteCuts(state);
  for (std::size_t i = 0; i < state.cuts.size(); ++i)
    if (IsApplied(state.cuts[i]))
      WriteSurface({state.cuts[i].surface.points, state.cuts[i].surface.triangles},
                   Path("cut_" + std::to_string(i) + "_surface.vtp"));
  WriteTetMesh(state.mesh, state.positions, Path("organ_final.vtu"));
  for (const Structure& structure : state.structures)
    WriteSurface(CurrentSurface(structure, state), Path(structure.name + "_final.vtp"));
}

}  // namespace kerf
