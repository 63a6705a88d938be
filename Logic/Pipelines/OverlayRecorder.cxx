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

std::mutex& OverlayRecorder::Drawing() {
  static std::mutex drawing;
  return drawing;
}

std::unique_ptr<OverlayRecorder> OverlayRecorder::Make(const ReplayRequest& request,
                                                       const CameraModel& camera,
                                                       double frames_per_second,
                                                       Progress& progress) {
  if (request.drawing == ReplayRequest::Drawing::None) return nullptr;
  std::string why_not;
  if (!RenderingAvailable(&why_not)) {
    progress.Warn("no overlay is drawn: " + why_not);
    return nullptr;
  }
  auto recorder = std::make_unique<OverlayRecorder>(camera);
  if (request.drawing == ReplayRequest::Drawing::Video) {
    recorder->writer_ = std::make_unique<VideoWriter>(
        request.results + "/overlay.mp4", camera.width, camera.height, frames_per_second);
    if (!recorder->writer_->Message().empty()) progress.Warn(recorder->writer_->Message());
  }
  return recorder;
}

OverlayRecorder::OverlayRecorder(const CameraModel& camera) {
  const std::lock_guard lock(Drawing());
  renderer_ = std::make_unique<OverlayRenderer>(camera);
}

OverlayRecorder::~OverlayRecorder() {
  const std::lock_guard lock(Drawing());
  renderer_.reset();
}

void OverlayRecorder::Add(const Frame& frame, const SessionFrame& report,
                          const RegistrationState& state, bool keep, ResultsWriter* results) {
  if (!keep && !writer_) return;
  cuts_.Update(state);
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
  for (const Points& lip : cuts_.Lips()) scene.lines.push_back({OverlayLine::Kind::Applied, lip});
  const Image instruments = InstrumentMask(frame);
  scene.instruments = &instruments;
  scene.status = Status(report, state, cuts_);
  Snapshot drawn{report.frame, report.time_s, {}};
  {
    const std::lock_guard lock(Drawing());
    drawn.image = renderer_->Render(scene);
  }
  if (writer_) writer_->Write(drawn.image);
  if (keep) snapshots_.push_back(std::move(drawn));
}

void OverlayRecorder::Finish() {
  if (writer_) writer_->Finish();
}

}  // namespace kerf
