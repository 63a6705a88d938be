#include "Adapters/Rendering/OverlayStatusPanel.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "Adapters/Rendering/OverlayCompositor.h"

namespace kerf {
namespace {

constexpr Color kAlarm{255, 80, 70}, kGround{12, 16, 22}, kText{240, 244, 248}, kDim{190, 198, 206};
constexpr double kGroundOpacity = 0.62;

std::string Format(const char* format, double value) {
  char buffer[64];
  std::snprintf(buffer, sizeof buffer, format, value);
  return buffer;
}

/// @return where it drew
PixelBox DrawGate(const OverlayStatus& status, int unit, TextPainter* text, Image* bgr) {
  using Gate = OverlayStatus::Gate;
  const bool off = status.gate == Gate::Off, amber = status.gate == Gate::Amber;
  const Color lamp = off ? kAlarm : amber ? Color{255, 190, 40} : Color{70, 225, 110};
  const std::string title = off ? "OVERLAY OFF" : amber ? "CAUTION" : "OVERLAY OK";
  const std::string why = status.gate == Gate::Green ? "" : status.reason;
  const int size = unit, pad = unit / 2;
  const int lamp_size = static_cast<int>(0.7 * unit);
  int width = lamp_size + 3 * pad + text->Layout(title, size, true).width;
  if (!why.empty()) width += pad + text->Layout(why, size, false).width;
  const int height = text->Layout(title, size, true).height + pad / 2;
  const PixelBox box{pad, pad, std::min(bgr->width - pad, pad + width), pad + height};
  TextPainter::Panel(box, off ? 0.8 : kGroundOpacity, kGround, bgr);
  const int lamp_y = box.y0 + (height - lamp_size) / 2;
  TextPainter::Panel({box.x0 + pad, lamp_y, box.x0 + pad + lamp_size, lamp_y + lamp_size}, 1.0,
                     lamp, bgr);
  int x = box.x0 + 2 * pad + lamp_size;
  text->Draw(title, x, box.y0 + pad / 4, size, true, lamp, bgr);
  x += text->Layout(title, size, true).width + pad;
  if (!why.empty()) text->Draw(why, x, box.y0 + pad / 4, size, false, kText, bgr);
  if (status.gate == Gate::Green) return box;
  // A frame around the picture: seen from the corner of the eye, and by those who do not read.
  const int t = std::max(2, unit / 5);
  const int w = bgr->width, h = bgr->height;
  for (const PixelBox& side : {PixelBox{0, 0, w, t}, PixelBox{0, h - t, w, h},
                               PixelBox{0, t, t, h - t}, PixelBox{w - t, t, w, h - t}})
    for (int y = side.y0; y < side.y1; ++y)
      for (int u = side.x0; u < side.x1; ++u)
        for (int k = 0; k < 3; ++k) bgr->data[3 * (std::size_t(y) * w + u) + k] = lamp[2 - k];
  return box;
}

/// @param gate box that is taken: where a long reason comes too near, the figures stand below it
void DrawFigures(const OverlayScene& scene, int unit, const PixelBox& gate, TextPainter* text,
                 Image* bgr) {
  const OverlayStatus& status = scene.status;
  const bool off = status.gate == OverlayStatus::Gate::Off;
  struct Line {
    std::string text;
    bool bold;
    Color color = kText;
  };
  std::vector<Line> lines;
  if (scene.frame.index >= 0)
    lines.push_back(
        {Format("%.2f s", scene.frame.time_s) + Format("   frame %.0f", scene.frame.index), false});
  // Figures about the tumour are as little to be trusted as the overlay.
  if (!off && std::isfinite(status.tumour_u95_mm))
    lines.push_back({Format("tumour \u00b1 %.1f mm", status.tumour_u95_mm), true});
  if (!off && std::isfinite(status.margin_mm))
    lines.push_back({Format("tumour to cut %.1f mm", status.margin_mm), true,
                     status.margin_mm < status.margin_alarm_mm ? kAlarm : kText});
  if (!status.note.empty()) lines.push_back({status.note, false});
  if (lines.empty()) return;
  const int size = static_cast<int>(0.9 * unit), pad = unit / 2;
  int width = 0, height = pad / 2;
  for (const auto& [line, bold, color] : lines) {
    width = std::max(width, text->Layout(line, size, bold).width);
    height += text->Layout(line, size, bold).height;
  }
  const int left = bgr->width - width - 3 * pad;
  const int top = gate.x1 + pad > left ? gate.y1 + pad / 2 : pad;
  const PixelBox box{left, top, bgr->width - pad, top + height};
  TextPainter::Panel(box, kGroundOpacity, kGround, bgr);
  int y = box.y0 + pad / 4;
  for (const auto& [line, bold, color] : lines) {
    const auto& glyphs = text->Layout(line, size, bold);
    text->Draw(line, box.x1 - pad - glyphs.width, y, size, bold, color, bgr);
    y += glyphs.height;
  }
}

void DrawLegend(const OverlayScene& scene, int unit, TextPainter* text, Image* bgr) {
  std::vector<std::pair<std::string, Color>> entries;
  const auto add = [&](const std::string& name, const Color& color) {
    for (const auto& e : entries)
      if (e.first == name) return;
    entries.push_back({name, color});
  };
  if (scene.organ) add("organ", overlay_colors::kOrgan);
  for (const auto& s : scene.structures) {
    if (!s.current || s.current->Empty()) continue;
    if (s.kind == OverlayStructure::Kind::Tumour) {
      add("tumour", overlay_colors::kTumour);
    } else {
      add("inner structure", overlay_colors::kInternal);
    }
  }
  const bool faces = std::any_of(scene.organ_cut_face.begin(), scene.organ_cut_face.end(),
                                 [](std::uint8_t f) { return f != 0; });
  if (faces) add("cut face", overlay_colors::kCutFace);
  for (const auto& line : scene.lines) {
    if (line.kind == OverlayLine::Kind::Applied) add("cut", overlay_colors::kCutLine);
    if (line.kind == OverlayLine::Kind::Proposed) add("cut, proposed", overlay_colors::kCutLine);
    if (line.kind == OverlayLine::Kind::Planned) add("planned line", overlay_colors::kPlanned);
  }
  if (entries.empty()) return;
  const int size = static_cast<int>(0.8 * unit), pad = unit / 2,
            swatch = static_cast<int>(0.6 * unit);
  int width = pad;
  for (const auto& [name, color] : entries)
    width += swatch + pad / 2 + text->Layout(name, size, false).width + pad;
  const int height = text->Layout("organ", size, false).height + pad / 2;
  const PixelBox box{pad, bgr->height - pad - height, pad + width, bgr->height - pad};
  TextPainter::Panel(box, kGroundOpacity, kGround, bgr);
  int x = box.x0 + pad;
  for (const auto& [name, color] : entries) {
    const int y = box.y0 + (height - swatch) / 2;
    TextPainter::Panel({x, y, x + swatch, y + swatch}, 1.0, color, bgr);
    x += swatch + pad / 2;
    text->Draw(name, x, box.y0 + pad / 4, size, false, kText, bgr);
    x += text->Layout(name, size, false).width + pad;
  }
}

}  // namespace

void DrawStatusPanel(const OverlayOptions& options, const OverlayScene& scene, TextPainter* text,
                     Image* bgr) {
  const int unit =
      std::max(11, static_cast<int>(std::lround(bgr->height / 28.0)));  // 19 px at 540 lines
  const bool off = scene.status.gate == OverlayStatus::Gate::Off;
  PixelBox gate;
  if (options.show_status || off) gate = DrawGate(scene.status, unit, text, bgr);
  if (options.show_status) DrawFigures(scene, unit, gate, text, bgr);
  if (options.show_legend && !off) DrawLegend(scene, unit, text, bgr);
  if (options.show_notice) {
    const std::string notice = "Research use, not a medical device";
    const int size = static_cast<int>(0.68 * unit), pad = unit / 2;
    const auto& glyphs = text->Layout(notice, size, false);
    const PixelBox box{bgr->width - glyphs.width - 2 * pad,
                       bgr->height - pad - glyphs.height - pad / 2, bgr->width - pad,
                       bgr->height - pad};
    TextPainter::Panel(box, 0.5, kGround, bgr);
    text->Draw(notice, box.x0 + pad / 2, box.y0 + pad / 4, size, false, kDim, bgr);
  }
}

}  // namespace kerf
