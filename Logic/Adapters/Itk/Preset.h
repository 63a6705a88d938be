#pragma once

#include <array>
#include <string>

#include "Adapters/Itk/Segmentation.h"

namespace kerf {

/// What is known of an organ before its CT is seen (Resources/Presets/<name>.json, built in). HU
/// ranges and volumes are physiology, not fitted to single patients.
struct OrganKnowledge {
  std::string name;
  std::array<double, 2> seed_hu;    ///< parenchyma, from without contrast to the brightest phase
  std::array<double, 2> window_hu;  ///< least half-widths below and above the local mean
  double reach_mm = 0;              ///< farthest an organ extends from a seed
  std::array<double, 2> volume_ml;  ///< plausible
  /// A part belongs to the organ when the neck to it is at least this fraction of the part's own
  /// half-thickness.
  double neck_ratio = 0.75;
  double working_spacing_mm = 2;  ///< of the grid on which parts and necks are found
  double thin_mm = 4;             ///< half-thickness below which tissue that leads away is no organ
  double closing_mm = 2;          ///< clefts up to twice this are bridged
  double rib_gap_mm = 0;  ///< gaps between ribs up to this are chest wall; 0 = far from ribs
  /// Whether brightness is followed (BrightnessDrift_hu): for organs that reach through half the
  /// body; in small ones the anatomy would be followed instead.
  bool follow_drift = false;
  struct Blob {
    double contrast_hu = 0;  ///< least difference from the parenchyma
    double enclosed = 1;     ///< least fraction of its surface that touches the organ
    double least_ml = 0;
  } tumour, internal;
};

const OrganKnowledge& KnowledgeOf(OrganPreset preset);

}  // namespace kerf
