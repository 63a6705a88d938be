#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "Core/Frame.h"
#include "Core/Types.h"

namespace kerf {

/// Half-open pixel rectangle.
struct PixelBox {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  bool Empty() const { return x1 <= x0 || y1 <= y0; }
  PixelBox Grown(int by, int width, int height) const {
    if (Empty()) return {};
    return {std::max(0, x0 - by), std::max(0, y0 - by), std::min(width, x1 + by),
            std::min(height, y1 + by)};
  }
  void Include(int x, int y) {
    if (Empty()) {
      *this = {x, y, x + 1, y + 1};
    } else {
      *this = {std::min(x0, x), std::min(y0, y), std::max(x1, x + 1), std::max(y1, y + 1)};
    }
  }
};

/// Red, green, blue in 0..255 as people write them; images are BGR.
using Color = std::array<std::uint8_t, 3>;

/// How much of each pixel a drawn thing covers, 0..255: lines are drawn here first, then blended
/// with one colour, so that they are smooth without multisampling.
class CoverageMap {
 public:
  CoverageMap(int width, int height)
      : width_(width), height_(height), data_(std::size_t(width) * height) {}
  int Width() const { return width_; }
  int Height() const { return height_; }
  std::uint8_t* Row(int y) { return data_.data() + std::size_t(y) * width_; }
  const std::uint8_t* Row(int y) const { return data_.data() + std::size_t(y) * width_; }
  void Clear(const PixelBox& box);
  /// [1 2 1]/4 in both directions, then times `gain`, saturated: a line of two pixels becomes a
  /// smooth one of three.
  void Smooth(const PixelBox& box, double gain);
  /// Line of this width through `pixels`, smooth edges. @param dash_px 0 = solid, else length of
  /// dash and of gap
  /// @return where it drew
  PixelBox DrawPolyline(const Pixels& pixels, double width_px, double dash_px = 0);
  PixelBox DrawDisc(const Vec2& center, double radius_px);
  PixelBox DrawCircle(const Vec2& center, double radius_px, double width_px);
  /// image = image·(1−a) + color·a with a = opacity·coverage.
  void Blend(const PixelBox& box, const Color& color, double opacity, Image* bgr) const;

 private:
  PixelBox DrawSegment(const Vec2& a, const Vec2& b, double width_px, double start_px,
                       double dash_px);
  int width_, height_;
  std::vector<std::uint8_t> data_;
};

/// Euclidean distance in px to the nearest set pixel of `mask` (non-zero inside `box`), for pixels
/// of `box`, row by row.
std::vector<float> DistanceToMask(const std::vector<std::uint8_t>& mask, int width,
                                  const PixelBox& box);

}  // namespace kerf
