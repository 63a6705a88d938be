#pragma once

#include <string>
#include <vector>

#include "Adapters/Itk/Seeds.h"
#include "Core/Progress.h"
#include "Core/Volume.h"

namespace kerf {

enum class OrganPreset { Liver, Kidney };

/// "liver" or "kidney". @throws UsageError otherwise
OrganPreset ParseOrganPreset(const std::string& name);
std::string ToString(OrganPreset preset);

struct SegmentationRequest {
  OrganPreset preset = OrganPreset::Liver;
  std::vector<Seed> seeds;   ///< inside the volume; without an organ seed the organ is looked for
  std::string seeds_source;  ///< path, for messages
};

/// What was found, for people and journals. Everything in `warnings` also went to progress.Warn().
struct SegmentationReport {
  std::string preset;                 ///< the one used
  std::vector<std::string> warnings;  ///< leak, implausible volume, cut off at the border …
  double organ_ml = 0;                ///< labels 1 + 2 + 3
  double tumour_ml = 0, internal_ml = 0;
  double organ_mean_hu = 0, organ_sd_hu = 0;  ///< of the parenchyma
  int components = 0;                         ///< of labels 1 + 2 + 3, 1 when all is well
  double left_out_ml = 0;  ///< came off the organ after its contour, or a seed's body beside it
  int holes = 0;           ///< enclosed background components left, 0 when all is well
  /// Share of the surface outside which tissue of the organ's own brightness lies: nothing is seen
  /// that ends the organ there.
  double open_surface = 0;
  bool touches_border = false;  ///< the organ is cut off by the volume's edge
  bool plausible = true;        ///< volume within the preset's range and no leak suspected
};

/// CT → labels 1 organ, 2 tumour, 3 inner structure on the volume's own grid. Cropped to a region
/// of interest, denoised, organ by edge-weighted growth from the seeds against automatic
/// background, boundary by geodesic active contour, components, holes and leaks checked; tumour and
/// inner structures from seeds or by intensity inside the organ. Deterministic. @throws InputError
/// for a seed outside the volume, and when nothing plausible is found (names the volume and what
/// was tried); @throws Cancelled
LabelMap SegmentCt(const Volume& ct, const SegmentationRequest& request, Progress& progress,
                   SegmentationReport* report = nullptr);

/// Whether the CT shows one organ and no more than its surroundings (less than 200 mm). Only there
/// the organ that is meant can be told without a preset.
bool HoldsOneOrgan(const Volume& ct);

/// The preset for a CT that holds one organ, by its intensity; said through progress.Warn().
/// @throws InputError where none stands out
OrganPreset AssumePreset(const Volume& ct, Progress& progress);

/// The same without a preset or seed, where one organ fills the CT's field of view (study CTs,
/// phantoms): organ found by itself, preset chosen by its intensity, which
/// is said through progress.Warn().
LabelMap SegmentStudyCt(const Volume& ct, Progress& progress, SegmentationReport* report = nullptr);

}  // namespace kerf
