#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "Adapters/Rendering/CoverageMap.h"
#include "Core/Frame.h"

namespace kerf {

/// Text and panels over an image, drawn by VTK's FreeType into coverage, cached by string.
class TextPainter {
 public:
  struct Glyphs {
    int width = 0,
        height = 0;  ///< the same height for every string of one size, so that lines stay level
    std::vector<std::uint8_t> coverage;  ///< rows top-down
  };
  /// @param size_px height of the font; @param bold for titles
  const Glyphs& Layout(const std::string& text, int size_px, bool bold);
  /// Upper left corner of the text's box at (x, y); what lies outside the image is cut off.
  void Draw(const std::string& text, int x, int y, int size_px, bool bold, const Color& color,
            Image* bgr);
  /// Darkens a rounded rectangle, so that text on it is legible over any tissue.
  static void Panel(const PixelBox& box, double opacity, const Color& color, Image* bgr);

 private:
  std::map<std::pair<std::string, int>, Glyphs> cache_;
};

}  // namespace kerf
