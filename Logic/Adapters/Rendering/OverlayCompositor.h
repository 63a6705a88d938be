#pragma once

#include "Adapters/Rendering/CoverageMap.h"
#include "Adapters/Rendering/GeometryBuffers.h"
#include "Adapters/Rendering/OverlayScene.h"
#include "Core/Camera.h"

namespace kerf {

/// Colours that read on red tissue and stay apart for colour-blind eyes.
namespace overlay_colors {
inline constexpr Color kOrgan{150, 215, 255};
inline constexpr Color kTumour{205, 255, 40};
inline constexpr Color kInternal{95, 150, 255};
inline constexpr Color kCutFace{255, 150, 30};
inline constexpr Color kCutLine{255, 240, 90};
inline constexpr Color kPlanned{255, 255, 255};
}  // namespace overlay_colors

/// Paints the geometry buffers over the frame: what is inside the organ first, then the translucent
/// organ, then lines, then the instruments of the raw frame again. Scratch memory is kept between
/// frames.
class OverlayCompositor {
 public:
  OverlayCompositor(int width, int height) : line_(width, height), mask_(width, height) {}
  /// @param bgr in: the raw frame; out: with the overlay
  void Compose(const CameraModel& camera, const OverlayOptions& options, const OverlayScene& scene,
               const GeometryBuffer& front, const GeometryBuffer& inside, Image* bgr);

 private:
  void PaintSurfaces(const OverlayOptions& options, const GeometryBuffer& front,
                     const GeometryBuffer& inside, Image* bgr) const;
  void PaintEdges(const OverlayOptions& options, const GeometryBuffer& front,
                  const GeometryBuffer& inside, Image* bgr);
  void PaintMargins(const CameraModel& camera, const OverlayScene& scene,
                    const GeometryBuffer& inside, Image* bgr);
  void PaintLines(const CameraModel& camera, const OverlayScene& scene, Image* bgr);
  void PaintFeatures(const FeatureSet& features, Image* bgr);
  void KeepInstruments(const Image& mask, const Image& raw, Image* bgr);
  /// Line with a thin dark seam on both sides, so that it reads on bright and on dark ground;
  /// clears the map.
  void Stroke(const PixelBox& box, const Color& color, double opacity, Image* bgr);
  bool InWindow(int x, int y) const;

  CoverageMap line_, mask_;
  PixelBox box_;  ///< where anything is
  PixelBox front_box_, cut_box_, internal_box_, tumour_box_;
  float nearest_mm_ = 0, farthest_mm_ = 0;
  Vec2 window_ = Vec2::Zero();
  double window_radius_ = 0;  ///< 0 = no window
};

}  // namespace kerf
