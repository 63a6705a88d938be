#include "Pipelines/ReportPlot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace kerf {
namespace {

constexpr double kWidth = 860, kHeight = 270, kLeft = 62, kRight = 20, kTop = 30, kBottom = 46;
const char* const kPalette[] = {"#2f6fde", "#e07b1f", "#2f9e5b", "#b4489e",
                                "#8a6d1f", "#1f9fb0", "#c8443a", "#6a6fb8"};

std::string ColorOf(const Plot& plot, std::size_t i) {
  return plot.series[i].color.empty() ? kPalette[i % 8] : EscapeHtml(plot.series[i].color);
}

struct Axis {
  double low = 0, high = 1, pixel_low = 0, pixel_high = 1;
  double operator()(double v) const {
    return pixel_low + (v - low) / (high - low) * (pixel_high - pixel_low);
  }
};

void Extend(double v, double* low, double* high) {
  if (!std::isfinite(v)) return;
  *low = std::min(*low, v);
  *high = std::max(*high, v);
}

// Tops of the stacked areas, one row per series.
std::vector<std::vector<double>> Tops(const Plot& plot) {
  std::vector<std::vector<double>> tops;
  for (const PlotSeries& s : plot.series) {
    std::vector<double> top = s.y;
    for (std::size_t i = 0; i < top.size(); ++i) {
      if (!std::isfinite(top[i])) top[i] = 0;
      if (plot.stacked && !tops.empty()) top[i] += tops.back()[i];
      if (!plot.stacked) top[i] = s.y[i];
    }
    tops.push_back(std::move(top));
  }
  return tops;
}

std::string Path(const Axis& ax, const Axis& ay, const std::vector<double>& x,
                 const std::vector<double>& y) {
  std::string path;
  bool open = false;
  for (std::size_t i = 0; i < std::min(x.size(), y.size()); ++i) {
    if (!std::isfinite(y[i])) {
      open = false;
      continue;
    }
    path += fmt::format("{}{:.1f} {:.1f}", open ? 'L' : 'M', ax(x[i]),
                        ay(std::clamp(y[i], ay.low, ay.high)));
    open = true;
  }
  return path;
}

std::string Text(double x, double y, const char* anchor, const std::string& text,
                 const char* extra = "") {
  return fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\" {}>{}</text>", x, y,
                     anchor, extra, EscapeHtml(text));
}

std::string Grid(const Plot& plot, const Axis& ax, const Axis& ay) {
  std::string svg;
  for (double v : NiceTicks(ay.low, ay.high, 5)) {
    if (v < ay.low - 1e-9 || v > ay.high + 1e-9) continue;
    svg += fmt::format("<path class=\"grid\" d=\"M{} {:.1f}H{}\"/>", kLeft, ay(v), kWidth - kRight);
    svg += Text(kLeft - 8, ay(v) + 4, "end", fmt::format("{:g}", v));
  }
  for (double v : NiceTicks(ax.low, ax.high, 10)) {
    if (v < ax.low - 1e-9 || v > ax.high + 1e-9) continue;
    svg += Text(ax(v), kHeight - kBottom + 18, "middle", fmt::format("{:g}", v));
  }
  svg +=
      Text(0.5 * (kLeft + kWidth - kRight), kHeight - 8, "middle", plot.x_label, "class=\"axis\"");
  svg += Text(-0.5 * (kTop + kHeight - kBottom), 14, "middle", plot.y_label,
              "class=\"axis\" transform=\"rotate(-90)\"");
  return svg;
}

std::string Legend(const Plot& plot) {
  std::string svg;
  double x = kWidth - kRight;
  for (std::size_t i = plot.series.size(); i-- > 0;) {
    if (plot.series[i].label.empty()) continue;
    svg += Text(x, 17, "end", plot.series[i].label);
    x -= 6.6 * double(plot.series[i].label.size()) + 16;  // width of a letter at this size
    svg +=
        fmt::format("<rect x=\"{:.1f}\" y=\"8\" width=\"10\" height=\"10\" rx=\"2\" fill=\"{}\"/>",
                    x, ColorOf(plot, i));
    x -= 12;
  }
  return svg;
}

}  // namespace

std::string EscapeHtml(const std::string& text) {
  std::string out;
  for (char c : text) switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\'':
        out += "&#39;";
        break;
      default:
        out += c;
    }
  return out;
}

std::vector<double> NiceTicks(double low, double high, int wanted) {
  if (!(high > low) || !std::isfinite(high - low) || wanted < 1) return {low};
  const double raw = (high - low) / wanted, power = std::pow(10.0, std::floor(std::log10(raw)));
  double step = 10 * power;
  for (double m : {1.0, 2.0, 5.0})
    if (m * power >= raw * 0.999) {
      step = m * power;
      break;
    }
  std::vector<double> ticks;
  for (double k = std::floor(low / step); k * step < high + step * 0.999; ++k)
    ticks.push_back(k == 0 ? 0.0 : k * step);
  return ticks;
}

std::string ToSvg(const Plot& plot) {
  const double infinity = std::numeric_limits<double>::infinity();
  const auto tops = Tops(plot);
  double x_low = infinity, x_high = -infinity, y_low = 0, y_high = 0;
  for (std::size_t s = 0; s < plot.series.size(); ++s) {
    for (double x : plot.series[s].x) Extend(x, &x_low, &x_high);
    for (double y : tops[s]) Extend(y, &y_low, &y_high);
  }
  for (const auto& band : plot.bands) {
    Extend(band.x0, &x_low, &x_high);
    Extend(band.x1, &x_low, &x_high);
  }
  for (const auto& [y, label] : plot.references) Extend(y, &y_low, &y_high);
  if (!(x_high > x_low)) {
    x_low = std::isfinite(x_low) ? x_low : 0;
    x_high = x_low + 1;
  }
  if (!(y_high > y_low)) y_high = y_low + 1;
  y_high = plot.y_max ? *plot.y_max : NiceTicks(y_low, y_high, 5).back();
  const Axis ax{x_low, x_high, kLeft, kWidth - kRight}, ay{y_low, y_high, kHeight - kBottom, kTop};

  std::string svg = fmt::format("<svg viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"{}\">",
                                kWidth, kHeight, EscapeHtml(plot.title));
  svg += Text(kLeft, 17, "start", plot.title, "class=\"title\"");
  svg += Grid(plot, ax, ay);
  for (const auto& band : plot.bands)
    svg += fmt::format(
        "<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"7\" fill=\"{}\"/>", ax(band.x0),
        kHeight - kBottom - 7, std::max(0.5, ax(band.x1) - ax(band.x0)), EscapeHtml(band.color));
  // The tallest area first: each next one covers its lower part.
  for (std::size_t k = 0; k < plot.series.size(); ++k) {
    const std::size_t i = plot.stacked ? plot.series.size() - 1 - k : k;
    std::string path = Path(ax, ay, plot.series[i].x, tops[i]);
    if (path.empty()) continue;
    if (plot.stacked)
      svg += fmt::format("<path d=\"{}L{:.1f} {:.1f}L{:.1f} {:.1f}Z\" fill=\"{}\"/>", path,
                         ax(plot.series[i].x.back()), ay(y_low), ax(plot.series[i].x.front()),
                         ay(y_low), ColorOf(plot, i));
    else
      svg += fmt::format("<path class=\"curve\" d=\"{}\" stroke=\"{}\"/>", path, ColorOf(plot, i));
  }
  for (const auto& [y, label] : plot.references) {
    svg += fmt::format("<path class=\"reference\" d=\"M{} {:.1f}H{}\"/>", kLeft, ay(y),
                       kWidth - kRight);
    svg += Text(kLeft + 6, ay(y) - 4, "start", label, "class=\"note\"");
  }
  for (const auto& [x, label] : plot.marks) {
    svg +=
        fmt::format("<path class=\"mark\" d=\"M{:.1f} {}V{}\"/>", ax(x), kTop, kHeight - kBottom);
    svg += Text(ax(x) + 5, kTop + 12, "start", label, "class=\"note\"");
  }
  return svg + Legend(plot) + "</svg>";
}

}  // namespace kerf
