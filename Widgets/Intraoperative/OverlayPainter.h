#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "Adapters/Rendering/OverlayScene.h"
#include "Core/Camera.h"
#include "Session/IntraoperativeSnapshot.h"

namespace kerf {

/// Draws snapshots and the exposure with the overlay renderer, in a thread of its own that steps
/// behind the others: the registration waits for no picture, the window for those only that it
/// wants at once. Called from one thread (the window's); throws std::runtime_error on construction
/// where nothing can be drawn.
class OverlayPainter {
 public:
  /// @param on_painted from the painter's thread, whenever Take() has something; must be quick
  explicit OverlayPainter(const CameraModel& camera, std::function<void()> on_painted = {});
  ~OverlayPainter();  ///< waits for the picture in work

  /// Of what is begun from now on.
  void SetOptions(const OverlayOptions& options);
  /// Distances between tumour and cut below it are an alarm, mm.
  void SetMarginAlarm(double mm);

  /// The newest order only is drawn: one that was not begun yet is replaced.
  void Begin(std::shared_ptr<const IntraoperativeSnapshot> snapshot);
  struct Painted {
    std::shared_ptr<const IntraoperativeSnapshot> snapshot;
    Image picture;  ///< the model over the frame that it belongs to, BGR
  };
  /// The newest picture that was begun and is done; each is given once. Throws what drawing threw.
  std::optional<Painted> Take();
  /// What was begun is not wanted any more: Take() does not give it.
  void Forget();
  /// The same, and nothing is in work when it returns: VTK draws the text of all windows with one
  /// font engine, which must not be used by two threads.
  void Rest();

  /// At once; waits for the picture in work.
  Image Paint(const IntraoperativeSnapshot& snapshot);
  /// The model at rest with a pose that is not accepted yet; at once.
  Image PaintExposure(const CameraModel& camera, const Frame& frame, const SurfaceMesh& organ,
                      const std::vector<Structure>& structures);

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace kerf
