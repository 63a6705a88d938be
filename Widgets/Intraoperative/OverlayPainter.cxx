#include "Intraoperative/OverlayPainter.h"

#include <cmath>
#include <cstdio>

#include "Adapters/OpenCv/ImageMasks.h"
#include "Adapters/Rendering/OverlayRenderer.h"

namespace kerf {
namespace {

OverlayStructure::Kind KindOf(const std::string& name) {
  return name == "tumour" ? OverlayStructure::Kind::Tumour : OverlayStructure::Kind::Internal;
}

OverlayStatus::Gate GateOf(GateState state) {
  return state == GateState::Green   ? OverlayStatus::Gate::Green
         : state == GateState::Amber ? OverlayStatus::Gate::Amber
                                     : OverlayStatus::Gate::Off;
}

}  // namespace

OverlayPainter::OverlayPainter(const CameraModel& camera)
    : renderer_(std::make_unique<OverlayRenderer>(camera)) {}

OverlayPainter::~OverlayPainter() = default;

void OverlayPainter::SetOptions(const OverlayOptions& options) {
  options_ = options;
  renderer_->SetOptions(options);
}

Image OverlayPainter::Paint(const IntraoperativeSnapshot& snapshot) {
  OverlayScene scene;
  scene.frame = snapshot.frame;
  scene.organ = &snapshot.organ;
  scene.organ_cut_face = snapshot.organ_cut_face;
  for (const auto& part : snapshot.structures)
    scene.structures.push_back({KindOf(part.name), &part.surface});
  const auto add = [&](const std::vector<Points>& lines, OverlayLine::Kind kind) {
    for (const Points& line : lines) scene.lines.push_back({kind, line});
  };
  add(snapshot.planned_lines, OverlayLine::Kind::Planned);
  add(snapshot.applied_lines, OverlayLine::Kind::Applied);
  add(snapshot.proposed_lines, OverlayLine::Kind::Proposed);
  const Image instruments = InstrumentMask(snapshot.frame);
  if (snapshot.frame.image) scene.instruments = &instruments;
  scene.status.gate = GateOf(snapshot.gate);
  scene.status.reason = snapshot.reason;
  scene.status.tumour_u95_mm = snapshot.reliability.tumour_u95_mm;
  scene.status.margin_mm = snapshot.margin_mm;
  scene.status.margin_alarm_mm = margin_alarm_mm_;
  if (snapshot.gate != GateState::Off && std::isfinite(snapshot.deviation.mean_mm)) {
    char note[64];
    std::snprintf(note, sizeof note, "plan to cut %.1f mm, at most %.1f",
                  snapshot.deviation.mean_mm, snapshot.deviation.max_mm);
    scene.status.note = note;
  }
  return renderer_->Render(scene);
}

Image OverlayPainter::PaintExposure(const CameraModel& camera, const Frame& frame,
                                    const SurfaceMesh& organ,
                                    const std::vector<Structure>& structures) {
  renderer_->SetCamera(camera);
  OverlayScene scene;
  scene.frame = frame;
  scene.organ = &organ;
  for (const Structure& structure : structures)
    if (!structure.rest.Empty())
      scene.structures.push_back({KindOf(structure.name), &structure.rest});
  scene.status.gate = OverlayStatus::Gate::Amber;
  scene.status.reason = "registration not accepted yet";
  return renderer_->Render(scene);
}

}  // namespace kerf
