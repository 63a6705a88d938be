#include "Pipelines/OverlayRecorder.h"

#include <fmt/format.h>

#include <algorithm>

#include "Adapters/OpenCv/ImageMasks.h"
#include "Adapters/Rendering/VirtualDisplay.h"

namespace kerf {
namespace {

OverlayStatus Status(const SessionFrame& report, const RegistrationState& state,
                     const CutView& cuts) {
  OverlayStatus status;
  const Reliability& r = report.reliability;
  status.gate = r.state == GateState::Green   ? OverlayStatus::Gate::Green
                : r.state == GateState::Amber ? OverlayStatus::Gate::Amber
                                              : OverlayStatus::Gate::Off;
  status.reason = r.reason;
  for (const Structure& structure : state.structures)
    if (structure.name == "tumour") status.tumour_u95_mm = r.tumour_u95_mm;
  // A margin within the tumour's uncertainty may be none.
  status.margin_mm = cuts.TumourMargin_mm();
  status.margin_alarm_mm = status.tumour_u95_mm;
  const auto opened = std::count_if(state.cuts.begin(), state.cuts.end(), [](const ModelCut& cut) {
    return cut.surface.triangles.rows() > 0;
  });
  if (opened > 0)
    status.note = fmt::format("{} cut{} in the model", opened, opened == 1 ? "" : "s");
  return status;
}

}  // namespace

std::unique_ptr<OverlayRecorder> OverlayRecorder::Make(const std::string& results,
                                                       const CameraModel& camera,
                                                       double frames_per_second,
                                                       Progress& progress) {
  std::string why_not;
  if (!RenderingAvailable(&why_not)) {
    progress.Warn("no overlay is drawn: " + why_not);
    return nullptr;
  }
  return std::make_unique<OverlayRecorder>(results + "/overlay.mp4", camera, frames_per_second);
}

OverlayRecorder::OverlayRecorder(const std::string& path, const CameraModel& camera,
                                 double frames_per_second)
    : renderer_(camera), writer_(path, camera.width, camera.height, frames_per_second) {}

void OverlayRecorder::Add(const Frame& frame, const SessionFrame& report,
                          const RegistrationState& state, ResultsWriter* results) {
  const ResultsWriter::OrganView& view = results->View(state);
  OverlayScene scene;
  scene.frame = frame;
  scene.organ = &view.current;
  scene.organ_cut_face = view.cut_face;
  std::vector<SurfaceMesh> current;
  current.reserve(state.structures.size());
  for (const Structure& structure : state.structures) {
    if (structure.rest.Empty()) continue;
    current.push_back({structure.embedding.Positions(state.positions, state.mesh.tets),
                       structure.rest.triangles});
    scene.structures.push_back({structure.name == "tumour" ? OverlayStructure::Kind::Tumour
                                                           : OverlayStructure::Kind::Internal,
                                &current.back()});
  }
  cuts_.Update(state);
  for (const Points& lip : cuts_.Lips()) scene.lines.push_back({OverlayLine::Kind::Applied, lip});
  const Image instruments = InstrumentMask(frame);
  scene.instruments = &instruments;
  scene.status = Status(report, state, cuts_);
  last_ = {report.frame, report.time_s, renderer_.Render(scene)};
  writer_.Write(last_.image);
}

void OverlayRecorder::Finish() { writer_.Finish(); }

}  // namespace kerf
