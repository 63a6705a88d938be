#pragma once

#include <memory>

#include "Adapters/Rendering/OverlayScene.h"
#include "Core/Camera.h"
#include "Core/Frame.h"

namespace kerf {

/// Draws the model over the raw video frame, aligned with the lens (distortion included) to a
/// fraction of a pixel. VTK renders the geometry off-screen into buffers (depth, facing, class); a
/// compositor paints outlines, the translucent organ and what lies inside it over the frame. When
/// the gate is Off nothing but the frame and the reason is shown. Not thread-safe: construct, use
/// and destroy in one thread.
class OverlayRenderer {
 public:
  /// @param camera lens and pose; its size is the size of the result
  /// @throws std::runtime_error where RenderingAvailable() is false; InputError on a broken camera
  explicit OverlayRenderer(const CameraModel& camera, const OverlayOptions& options = {});
  ~OverlayRenderer();
  OverlayRenderer(const OverlayRenderer&) = delete;
  OverlayRenderer& operator=(const OverlayRenderer&) = delete;

  /// @return BGR image of the camera's size
  /// @throws InputError when the frame, the instrument mask or a list does not fit the camera or
  /// the mesh
  Image Render(const OverlayScene& scene);

  void SetOptions(const OverlayOptions& options);
  void SetCamera(const CameraModel& camera);

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace kerf
