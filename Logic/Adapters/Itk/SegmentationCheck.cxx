#include "Adapters/Itk/SegmentationCheck.h"

#include <fmt/format.h>

#include <cmath>

#include "Adapters/Itk/Statistics.h"
#include "Adapters/Itk/WorkingGrid.h"

namespace kerf {
namespace {

/// An organ touches neighbours that are as bright with less of its surface than this.
constexpr double kOpenSurface = 0.1;

/// Index in the CT of a crop's first voxel.
Eigen::Vector3i FirstVoxel(const GridGeometry& crop, const GridGeometry& ct) {
  return ct.IndexFromWorld(crop.origin_mm).array().round().cast<int>();
}

bool TouchesBorder(const Mask& organ, const GridGeometry& ct) {
  const Eigen::Vector3i first = FirstVoxel(organ.grid, ct);
  std::size_t at = 0;
  for (int k = 0; k < organ.grid.size[2]; ++k)
    for (int j = 0; j < organ.grid.size[1]; ++j)
      for (int i = 0; i < organ.grid.size[0]; ++i, ++at) {
        if (!organ.values[at]) continue;
        const Eigen::Vector3i voxel = first + Eigen::Vector3i(i, j, k);
        if (voxel.minCoeff() <= 0 || (ct.size - voxel).minCoeff() <= 1) return true;
      }
  return false;
}

}  // namespace

void CheckSegmentation(const Volume& ct, const OrganKnowledge& knowledge, const OrganRegion& region,
                       const InnerStructures& inner, SegmentationReport* report) {
  const Mask& organ = region.mask;
  report->preset = knowledge.name;
  report->organ_ml = Volume_ml(organ);
  report->tumour_ml = Volume_ml(inner.tumour);
  report->internal_ml = Volume_ml(inner.internal);
  std::vector<float> parenchyma;
  const Eigen::Vector3i first = FirstVoxel(organ.grid, ct.grid);
  std::size_t at = 0;
  for (int k = 0; k < organ.grid.size[2]; ++k)
    for (int j = 0; j < organ.grid.size[1]; ++j)
      for (int i = 0; i < organ.grid.size[0]; ++i, ++at)
        if (organ.values[at] && !inner.tumour.values[at] && !inner.internal.values[at])
          parenchyma.push_back(
              (*ct.voxels)[ct.grid.Offset(first[0] + i, first[1] + j, first[2] + k)]);
  report->organ_mean_hu = parenchyma.empty() ? region.tissue.mean_hu : Median(parenchyma);
  report->organ_sd_hu = parenchyma.empty() ? 0 : Spread(parenchyma, report->organ_mean_hu);
  std::vector<std::size_t> sizes;
  Components(organ, &sizes);
  report->components = static_cast<int>(sizes.size());
  FillHoles(organ, &report->holes);
  report->touches_border = TouchesBorder(organ, ct.grid);
  report->open_surface = OpenShare(organ, region.alike);

  auto& warnings = report->warnings;
  if (report->organ_ml < knowledge.volume_ml[0] || report->organ_ml > knowledge.volume_ml[1]) {
    report->plausible = false;
    warnings.push_back(fmt::format(
        "the {} that was found has {:.0f} ml, plausible are {:.0f} to {:.0f} ml: {}",
        knowledge.name, report->organ_ml, knowledge.volume_ml[0], knowledge.volume_ml[1],
        report->organ_ml > knowledge.volume_ml[1]
            ? "it may have leaked into a neighbour; add background seeds"
            : "part of it may be missing; add organ seeds"));
  }
  if (report->open_surface > kOpenSurface)
    warnings.push_back(fmt::format(
        "outside {:.0f} % of the {}'s surface lies tissue of its own brightness, so that no edge "
        "ends "
        "it there: look whether a part is missing (add organ seeds) or a neighbour is as bright",
        100 * report->open_surface, knowledge.name));
  if (report->touches_border)
    warnings.push_back("the organ reaches the volume's border: it is cut off there");
  if (report->components != 1)
    warnings.push_back(fmt::format("the organ has {} pieces", report->components));
  if (report->holes != 0)
    warnings.push_back(
        fmt::format("the organ has {} hole{}", report->holes, report->holes == 1 ? "" : "s"));
  if (report->tumour_ml + report->internal_ml > 0.6 * report->organ_ml) {
    report->plausible = false;
    warnings.push_back("tumour and inner structures fill more than half of the organ");
  }
}

void CheckLeftOut(const Mask& found, const Mask& kept, const OrganKnowledge& knowledge,
                  const std::vector<Seed>& seeds, SegmentationReport* report) {
  Mask left = found;
  for (std::size_t i = 0; i < left.values.size(); ++i)
    left.values[i] = found.values[i] && !kept.values[i];
  report->left_out_ml = Volume_ml(left);
  if (report->left_out_ml >= knowledge.tumour.least_ml)
    report->warnings.push_back(
        fmt::format("{:.1f} ml that do not touch the organ were left out", report->left_out_ml));
  for (const Seed& seed : seeds) {
    if (seed.kind == SeedKind::Background) continue;
    const Eigen::Vector3i at = NearestIndex(kept.grid, seed.position_mm);
    if (!kept.values[kept.grid.Offset(at[0], at[1], at[2])])
      report->warnings.push_back(
          fmt::format("the seed {} lies outside the organ that was found", seed.id));
  }
}

}  // namespace kerf
