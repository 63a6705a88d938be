#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "Core/Features.h"
#include "Core/Frame.h"
#include "Core/SurfaceMesh.h"
#include "Core/Types.h"

namespace kerf {

/// Outline: edges only. SeeThrough: a circular window through which the inside is seen, edges
/// elsewhere (surgeons preferred it: docs/reference/overlay.md). Full: translucent organ with
/// everything inside.
enum class OverlayPreset { Outline, SeeThrough, Full };
/// @throws UsageError on a name other than outline, see-through, full
OverlayPreset OverlayPresetFromName(const std::string& name);

struct OverlayOptions {
  OverlayPreset preset = OverlayPreset::Full;
  double organ_opacity = 0.30;      ///< of the organ seen face on; its rim is denser
  double structure_opacity = 0.85;  ///< of tumour and inner structures just under the surface
  std::optional<Vec2>
      window_px;  ///< centre of the see-through window; default: the tumour, else the image centre
  double window_radius_px = 0;  ///< 0 = a quarter of the image height
  bool depth_cue = true;        ///< nearer is brighter
  bool show_features = false;
  bool show_status = true;  ///< gate, reason, time, tumour ± mm
  bool show_legend = true;
  bool show_notice = true;  ///< "Research use, not a medical device"
};

struct OverlayStructure {
  enum class Kind { Tumour, Internal } kind = Kind::Internal;
  const SurfaceMesh* current = nullptr;  ///< current coordinates, LPS, mm
};

struct OverlayLine {
  /// Applied: a cut of the model. Proposed: provisional, drawn dashed. Planned: the planned
  /// resection line.
  enum class Kind { Applied, Proposed, Planned } kind = Kind::Applied;
  Points current;  ///< N×3 ordered, LPS, mm
};

struct OverlayStatus {
  enum class Gate { Green, Amber, Off } gate = Gate::Green;
  std::string reason;  ///< in words; shown when amber or off
  /// 95 % bound of the tumour's position error, mm; NaN = unknown, not shown
  double tumour_u95_mm = std::numeric_limits<double>::quiet_NaN();
  /// Smallest distance between tumour and cut surface, mm; NaN = not shown
  double margin_mm = std::numeric_limits<double>::quiet_NaN();
  /// Planned smallest distance between tumour and cut, mm: a ring around the tumour, drawn at its
  /// mean depth; NaN = no plan
  double planned_margin_mm = std::numeric_limits<double>::quiet_NaN();
  double margin_alarm_mm =
      std::numeric_limits<double>::quiet_NaN();  ///< margins below it are shown in red
  std::string note;  ///< one more short line, for example "cut 1 at 3.24 s"
};

/// All that is drawn over one frame. Pointers are borrowed for the length of Render().
struct OverlayScene {
  Frame frame;  ///< raw (distorted) picture; without one the ground is dark grey
  const SurfaceMesh* organ = nullptr;  ///< current outer surface, cut faces included; null = none
  std::vector<std::uint8_t>
      organ_cut_face;  ///< per organ triangle: non-zero = face of a cut; empty = none
  std::vector<OverlayStructure> structures;
  std::vector<OverlayLine> lines;
  const FeatureSet* features = nullptr;  ///< drawn with options.show_features
  const Image* instruments =
      nullptr;  ///< 1 channel, size of the frame: non-zero stays in front of the overlay
  OverlayStatus status;
};

}  // namespace kerf
