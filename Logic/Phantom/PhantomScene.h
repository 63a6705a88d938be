#pragma once

#include "Core/Frame.h"
#include "Phantom/PhantomAnatomy.h"
#include "Phantom/PhantomTool.h"
#include "Phantom/Rasterizer.h"

namespace kerf {

/// What the laparoscope sees at one frame.
struct PhantomView {
  Image image;  ///< BGR, raw (distorted)
  Image mask;   ///< 255 organ visible, 128 organ hidden by a tool or grip, 0 other
  VisibilityBuffer organ{0, 0};
  std::vector<std::uint8_t> tool;  ///< per pixel: 1 where an instrument is in front
};

/// Renders the phantom: headlight at the camera, wet highlights, textures that stick to the rest
/// position, cut faces, instruments, a soft shadow on what lies behind, lens blur and sensor noise.
/// Deterministic.
class PhantomScene {
 public:
  PhantomScene(const PhantomSetup& setup, const PhantomAnatomy& anatomy);
  /// Without `draw` only mask and visibility are made.
  PhantomView Render(int frame, bool draw) const;

 private:
  Vec3 OrganColour(const PhantomSurfaceAtFrame& organ, const Points& world, const Points& normals,
                   const VisibilityBuffer& seen, std::size_t pixel) const;
  Vec3 ToolColour(const PhantomTool& tool, const Points& normals, const VisibilityBuffer& seen,
                  std::size_t pixel) const;
  std::vector<float> Shadow(const VisibilityBuffer& organ) const;

  const PhantomSetup& setup_;
  const PhantomAnatomy& anatomy_;
  PhantomMotion motion_;
  std::vector<Vec3> rays_;                   ///< unit viewing direction of each pixel, world
  std::vector<Eigen::Vector3f> background_;  ///< shaded, linear RGB
};

}  // namespace kerf
