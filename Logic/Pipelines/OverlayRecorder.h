#pragma once

#include <memory>
#include <string>
#include <vector>

#include "Adapters/Ffmpeg/VideoWriter.h"
#include "Adapters/Rendering/OverlayRenderer.h"
#include "Core/Progress.h"
#include "Pipelines/ResultsWriter.h"
#include "Registration/CutView.h"

namespace kerf {

/// Draws the overlay over every frame and records overlay.mp4: size, rate and frame count of the
/// source.
class OverlayRecorder {
 public:
  /// None (with a warning) where nothing can be drawn on this machine.
  static std::unique_ptr<OverlayRecorder> Make(const std::string& results,
                                               const CameraModel& camera, double frames_per_second,
                                               Progress& progress);
  OverlayRecorder(const std::string& path, const CameraModel& camera, double frames_per_second);

  void Add(const Frame& frame, const SessionFrame& report, const RegistrationState& state,
           ResultsWriter* results);
  /// Completes the file. @throws InputError when it cannot be written
  void Finish();

  struct Snapshot {
    int frame = 0;
    double time_s = 0.0;
    Image image;
  };
  /// Keep the overlay of this frame for the report.
  void KeepSnapshot() { snapshots_.push_back(last_); }
  const std::vector<Snapshot>& Snapshots() const { return snapshots_; }

 private:
  OverlayRenderer renderer_;
  VideoWriter writer_;
  CutView cuts_;
  Snapshot last_;
  std::vector<Snapshot> snapshots_;
};

}  // namespace kerf
