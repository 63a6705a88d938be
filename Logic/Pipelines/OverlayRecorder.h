#pragma once

#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "Adapters/Ffmpeg/VideoWriter.h"
#include "Adapters/Rendering/OverlayRenderer.h"
#include "Core/Progress.h"
#include "Pipelines/ReplayPipeline.h"
#include "Pipelines/ResultsWriter.h"
#include "Registration/CutView.h"

namespace kerf {

/// Draws the overlay over every frame and records overlay.mp4 (size, rate and frame count of the
/// source), or draws the pictures of the report alone. Several may be at work in threads of their
/// own: they draw one after the other, as VTK's text and OpenGL want it.
class OverlayRecorder {
 public:
  /// None where nothing is to be drawn, and (with a warning) where nothing can be drawn on this
  /// machine.
  static std::unique_ptr<OverlayRecorder> Make(const ReplayRequest& request,
                                               const CameraModel& camera, double frames_per_second,
                                               Progress& progress);
  explicit OverlayRecorder(const CameraModel& camera);
  ~OverlayRecorder();

  /// @param keep the overlay of this frame is for the report
  void Add(const Frame& frame, const SessionFrame& report, const RegistrationState& state,
           bool keep, ResultsWriter* results);
  /// Completes the file. @throws InputError when it cannot be written
  void Finish();

  struct Snapshot {
    int frame = 0;
    double time_s = 0.0;
    Image image;
  };
  const std::vector<Snapshot>& Snapshots() const { return snapshots_; }

  /// Held by whoever draws while other threads may draw too.
  static std::mutex& Drawing();

 private:
  std::unique_ptr<OverlayRenderer> renderer_;
  std::unique_ptr<VideoWriter> writer_;
  CutView cuts_;
  std::vector<Snapshot> snapshots_;
};

}  // namespace kerf
