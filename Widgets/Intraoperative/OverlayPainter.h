#pragma once

#include <memory>

#include "Adapters/Rendering/OverlayScene.h"
#include "Core/Camera.h"
#include "Session/IntraoperativeSnapshot.h"

namespace kerf {

class OverlayRenderer;

/// Draws snapshots and the exposure with the overlay renderer, and measures how that goes. GUI
/// thread; throws std::runtime_error on construction where nothing can be drawn.
class OverlayPainter {
 public:
  explicit OverlayPainter(const CameraModel& camera);
  ~OverlayPainter();

  void SetOptions(const OverlayOptions& options);
  const OverlayOptions& Options() const { return options_; }
  /// Distances between tumour and cut below it are an alarm, mm.
  void SetMarginAlarm(double mm) { margin_alarm_mm_ = mm; }

  /// The model over the frame that it belongs to.
  Image Paint(const IntraoperativeSnapshot& snapshot);
  /// The model at rest with a pose that is not accepted yet.
  Image PaintExposure(const CameraModel& camera, const Frame& frame, const SurfaceMesh& organ,
                      const std::vector<Structure>& structures);

 private:
  OverlayOptions options_;
  double margin_alarm_mm_ = 5.0;
  std::unique_ptr<OverlayRenderer> renderer_;
};

}  // namespace kerf
