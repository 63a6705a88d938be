#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace kerf {

/// A curve; a y that is not a number interrupts it.
struct PlotSeries {
  std::string label;
  std::vector<double> x, y;
  std::string color;  ///< CSS colour; empty = next of the palette
};

/// A line plot that stands on its own in a page: no scripts, no files beside it.
struct Plot {
  std::string title, x_label, y_label;
  std::vector<PlotSeries> series;
  bool stacked = false;         ///< areas on top of each other; all series share the first one's x
  std::optional<double> y_max;  ///< none = from the data
  struct Band {                 ///< coloured strip along the x axis
    double x0 = 0, x1 = 0;
    std::string color;
  };
  std::vector<Band> bands;
  std::vector<std::pair<double, std::string>> marks;       ///< vertical lines with a label
  std::vector<std::pair<double, std::string>> references;  ///< horizontal dashed lines with a label
};

/// Inline SVG, 860 units wide, scaled by its container. Text in `plot` is escaped.
std::string ToSvg(const Plot& plot);

/// Text made safe between tags and in attributes of HTML.
std::string EscapeHtml(const std::string& text);

/// Ticks at 1, 2 or 5 times a power of ten that cover [low, high], about `wanted` of them.
std::vector<double> NiceTicks(double low, double high, int wanted);

}  // namespace kerf
