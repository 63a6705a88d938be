#include "Adapters/Rendering/OverlayText.h"

#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkStdString.h>
#include <vtkTextProperty.h>
#include <vtkTextRenderer.h>

#include <cmath>

namespace kerf {

const TextPainter::Glyphs& TextPainter::Layout(const std::string& text, int size_px, bool bold) {
  const auto key = std::make_pair(text, bold ? -size_px : size_px);
  const auto found = cache_.find(key);
  if (found != cache_.end()) return found->second;
  if (cache_.size() > 500) cache_.clear();  // running clocks would fill it

  vtkNew<vtkTextProperty> property;
  property->SetFontFamilyToArial();
  property->SetFontSize(size_px);
  property->SetBold(bold);
  property->SetColor(1, 1, 1);
  property->SetOpacity(1);
  Glyphs glyphs;
  glyphs.height = static_cast<int>(std::lround(1.35 * size_px));
  const auto blank = [&] { glyphs.coverage.assign(std::size_t(glyphs.width) * glyphs.height, 0); };
  vtkTextRenderer* renderer = vtkTextRenderer::GetInstance();
  const vtkStdString utf8(text);
  vtkNew<vtkImageData> picture;
  int dims[2] = {0, 0}, box[4] = {0, 0, 0, 0};
  constexpr int kDotsPerInch = 72;  // so that a point is a pixel
  if (renderer && !text.empty() && renderer->GetBoundingBox(property, utf8, box, kDotsPerInch) &&
      renderer->RenderString(property, utf8, picture, dims, kDotsPerInch) &&
      picture->GetNumberOfScalarComponents() == 4) {
    glyphs.width = box[1] - box[0] + 1;
    blank();
    // Baseline at a fixed height: box[2] is the lowest pixel of the text relative to its anchor.
    const int baseline = static_cast<int>(std::lround(1.02 * size_px));
    const int rows = std::min(dims[1], box[3] - box[2] + 1);
    for (int r = 0; r < rows; ++r) {
      const int y = baseline - (box[2] + r);
      if (y < 0 || y >= glyphs.height) continue;
      const auto* line = static_cast<unsigned char*>(picture->GetScalarPointer(0, r, 0));
      for (int x = 0; x < std::min(dims[0], glyphs.width); ++x)
        glyphs.coverage[std::size_t(y) * glyphs.width + x] = line[4 * x + 3];
    }
  } else {
    blank();
  }
  return cache_.emplace(key, std::move(glyphs)).first->second;
}

void TextPainter::Draw(const std::string& text, int x, int y, int size_px, bool bold,
                       const Color& color, Image* bgr) {
  const Glyphs& g = Layout(text, size_px, bold);
  for (int r = 0; r < g.height; ++r) {
    const int v = y + r;
    if (v < 0 || v >= bgr->height) continue;
    for (int c = 0; c < g.width; ++c) {
      const int u = x + c, a = g.coverage[std::size_t(r) * g.width + c];
      if (a == 0 || u < 0 || u >= bgr->width) continue;
      std::uint8_t* out = bgr->data.data() + std::size_t(3) * (std::size_t(v) * bgr->width + u);
      for (int k = 0; k < 3; ++k)
        out[k] = static_cast<std::uint8_t>((out[k] * (255 - a) + color[2 - k] * a + 127) / 255);
    }
  }
}

void TextPainter::Panel(const PixelBox& box, double opacity, const Color& color, Image* bgr) {
  const double radius = std::min(6.0, 0.5 * (box.y1 - box.y0));
  const auto mix = [&](int below, int k, double a) {
    return static_cast<std::uint8_t>(std::lround(below * (1 - a) + color[2 - k] * a));
  };
  std::uint8_t full[3][256];  // next to all of it
  for (int k = 0; k < 3; ++k)
    for (int below = 0; below < 256; ++below) full[k][below] = mix(below, k, opacity);
  for (int y = std::max(0, box.y0); y < std::min(bgr->height, box.y1); ++y)
    for (int x = std::max(0, box.x0); x < std::min(bgr->width, box.x1); ++x) {
      std::uint8_t* out = bgr->data.data() + std::size_t(3) * (std::size_t(y) * bgr->width + x);
      const double dx = std::max({box.x0 + radius - x - 0.5, x + 0.5 - (box.x1 - radius), 0.0});
      const double dy = std::max({box.y0 + radius - y - 0.5, y + 0.5 - (box.y1 - radius), 0.0});
      if (dx == 0.0 || dy == 0.0) {
        for (int k = 0; k < 3; ++k) out[k] = full[k][out[k]];
        continue;
      }
      const double a = opacity * std::clamp(radius + 0.5 - std::hypot(dx, dy), 0.0, 1.0);
      for (int k = 0; k < 3; ++k) out[k] = mix(out[k], k, a);
    }
}

}  // namespace kerf
