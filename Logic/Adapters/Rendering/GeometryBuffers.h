#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "Adapters/Rendering/CoverageMap.h"
#include "Core/Camera.h"
#include "Core/SurfaceMesh.h"

namespace kerf {

/// What VTK sees through each pixel, rows top-down, width×height of the camera.
struct GeometryBuffer {
  int width = 0, height = 0;
  PixelBox box;                       ///< outside it nothing is seen
  std::vector<std::uint8_t> surface;  ///< class of the front-most surface, 0 = nothing
  std::vector<std::uint8_t> facing;   ///< |normal · view| in 1/255; meaningless outside the box
  std::vector<float> depth_mm;        ///< along the optical axis; far plane where nothing is, and
                                      ///< meaningless outside the box
};

/// Renders surfaces off-screen into a GeometryBuffer: lens-distorted vertices, flat data instead of
/// light, so that the look is decided afterwards. Organ and inner structures get a buffer of their
/// own each, by one VTK render.
class GeometryBuffers {
 public:
  enum Surface : std::uint8_t { Nothing = 0, Outer = 1, CutFace = 2, Internal = 3, Tumour = 4 };
  struct Part {
    const SurfaceMesh* mesh = nullptr;  ///< current coordinates, LPS
    Surface surface = Outer;
    const std::vector<std::uint8_t>* cut_face =
        nullptr;  ///< per triangle, non-zero = CutFace; may be null
  };

  explicit GeometryBuffers(const CameraModel& camera);
  ~GeometryBuffers();
  /// Another pose or lens; cheap while the size stays, so that a model can be dragged.
  void SetCamera(const CameraModel& camera);
  /// Draws both sets; the results are in Front() and Inside() until the next call.
  void Render(const std::vector<Part>& front, const std::vector<Part>& inside);
  const GeometryBuffer& Front() const;
  const GeometryBuffer& Inside() const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace kerf
