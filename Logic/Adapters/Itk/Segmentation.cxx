#include "Adapters/Itk/Segmentation.h"

#include <fmt/format.h>

#include "Adapters/Itk/InnerStructures.h"
#include "Adapters/Itk/OrganRegion.h"
#include "Adapters/Itk/OrganSearch.h"
#include "Adapters/Itk/Statistics.h"
#include "Adapters/Itk/WorkingGrid.h"
#include "Core/Errors.h"

namespace kerf {
namespace {

/// An organ touches neighbours that are as bright with less of its surface than this.
constexpr double kOpenSurface = 0.1;

std::vector<Vec3> PointsOf(const std::vector<Seed>& seeds, SeedKind kind) {
  std::vector<Vec3> points;
  for (const Seed& seed : seeds)
    if (seed.kind == kind) points.push_back(seed.position_mm);
  return points;
}

bool TouchesBorder(const Mask& organ, const GridGeometry& ct) {
  const Vec3 first = ct.IndexFromWorld(organ.grid.origin_mm);
  std::size_t at = 0;
  for (int k = 0; k < organ.grid.size[2]; ++k)
    for (int j = 0; j < organ.grid.size[1]; ++j)
      for (int i = 0; i < organ.grid.size[0]; ++i, ++at) {
        if (!organ.values[at]) continue;
        const Eigen::Vector3i voxel(int(std::lround(first[0])) + i, int(std::lround(first[1])) + j,
                                    int(std::lround(first[2])) + k);
        if (voxel.minCoeff() <= 0 || (ct.size - voxel).minCoeff() <= 1) return true;
      }
  return false;
}

/// The checks that a person would make, in numbers and sentences.
void Check(const Volume& ct, const OrganKnowledge& knowledge, const OrganRegion& region,
           const InnerStructures& inner, SegmentationReport* report) {
  const Mask& organ = region.mask;
  report->preset = knowledge.name;
  report->organ_ml = Volume_ml(organ);
  report->tumour_ml = Volume_ml(inner.tumour);
  report->internal_ml = Volume_ml(inner.internal);
  std::vector<float> parenchyma;
  const Vec3 first = ct.grid.IndexFromWorld(organ.grid.origin_mm);
  std::size_t at = 0;
  for (int k = 0; k < organ.grid.size[2]; ++k)
    for (int j = 0; j < organ.grid.size[1]; ++j)
      for (int i = 0; i < organ.grid.size[0]; ++i, ++at)
        if (organ.values[at] && !inner.tumour.values[at] && !inner.internal.values[at])
          parenchyma.push_back((*ct.voxels)[ct.grid.Offset(int(std::lround(first[0])) + i,
                                                           int(std::lround(first[1])) + j,
                                                           int(std::lround(first[2])) + k)]);
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
  if (report->holes != 0) warnings.push_back(fmt::format("the organ has {} holes", report->holes));
  if (report->tumour_ml + report->internal_ml > 0.6 * report->organ_ml) {
    report->plausible = false;
    warnings.push_back("tumour and inner structures fill more than half of the organ");
  }
}

void SayWhatWasAssumed(const Volume& ct, const FoundOrgan& found, Progress& progress) {
  progress.Warn(fmt::format("{}: no preset was given, taken as {} because of its {:.0f} HU",
                            ct.source, ToString(found.preset), found.mean_hu));
}

LabelMap Compose(const Volume& ct, const Mask& organ, const InnerStructures& inner) {
  LabelMap labels;
  labels.grid = ct.grid;
  labels.source = ct.source;
  labels.names = {{1, "organ"}, {2, "tumour"}, {3, "internal"}};
  auto voxels = std::make_shared<std::vector<std::uint8_t>>(ct.grid.VoxelCount(), 0);
  Paste(organ, ct.grid, 1, voxels.get());
  Paste(inner.tumour, ct.grid, 2, voxels.get());
  Paste(inner.internal, ct.grid, 3, voxels.get());
  labels.voxels = std::move(voxels);
  return labels;
}

LabelMap Segment(const Volume& ct, const OrganKnowledge& knowledge,
                 const SegmentationRequest& request, const std::vector<Vec3>& organ_seeds,
                 Progress& progress, SegmentationReport* report) {
  SubProgress organ_part(progress, 0.1, 0.75), inner_part(progress, 0.75, 0.95);
  OrganRegion region =
      FindOrgan(ct, knowledge, organ_seeds, PointsOf(request.seeds, SeedKind::Background),
                request.seeds_source.empty() ? ct.source : request.seeds_source, organ_part);
  InnerStructures inner = FindInnerStructures(
      ct, knowledge, region.tissue, region.drift_hu, PointsOf(request.seeds, SeedKind::Tumour),
      PointsOf(request.seeds, SeedKind::Internal), &region.mask, inner_part);
  region.mask = FillHoles(LargestComponent(region.mask));
  for (std::size_t i = 0; i < region.mask.values.size(); ++i)
    if (!region.mask.values[i]) inner.tumour.values[i] = inner.internal.values[i] = 0;
  SegmentationReport own;
  SegmentationReport& filled = report ? *report : own;
  filled = SegmentationReport();
  Check(ct, knowledge, region, inner, &filled);
  if (filled.tumour_ml > 0 && PointsOf(request.seeds, SeedKind::Tumour).empty())
    filled.warnings.push_back(fmt::format(
        "{:.1f} ml darker than the parenchyma were taken as tumour; check them", filled.tumour_ml));
  for (const std::string& warning : filled.warnings) progress.Warn(ct.source + ": " + warning);
  progress.Report(1, "segmented");
  return Compose(ct, region.mask, inner);
}

}  // namespace

LabelMap SegmentCt(const Volume& ct, const SegmentationRequest& request, Progress& progress,
                   SegmentationReport* report) {
  ct.grid.Validate(ct.source);
  CheckSeedsInside(request.seeds, ct.grid,
                   request.seeds_source.empty() ? ct.source : request.seeds_source);
  const OrganKnowledge& knowledge = KnowledgeOf(request.preset);
  std::vector<Vec3> seeds = PointsOf(request.seeds, SeedKind::Organ);
  if (seeds.empty()) {
    SubProgress search(progress, 0, 0.1);
    // A CT of one organ alone needs no seed; in a whole abdomen only the liver is unmistakable.
    if (HoldsOneOrgan(ct))
      seeds = {FindStudyOrgan(ct, search).seed_mm};
    else if (request.preset == OrganPreset::Liver)
      seeds = {FindLiverSeed(ct, knowledge, search)};
    else
      throw InputError(request.seeds_source.empty() ? ct.source : request.seeds_source,
                       "organ seed",
                       "there are two kidneys: place one seed in the kidney that is meant");
  }
  return Segment(ct, knowledge, request, seeds, progress, report);
}

bool HoldsOneOrgan(const Volume& ct) {
  constexpr double kLargestOrgan_mm = 200;
  return ct.grid.size.cast<double>().cwiseProduct(ct.grid.spacing_mm).maxCoeff() < kLargestOrgan_mm;
}

OrganPreset AssumePreset(const Volume& ct, Progress& progress) {
  const FoundOrgan found = FindStudyOrgan(ct, progress);
  SayWhatWasAssumed(ct, found, progress);
  return found.preset;
}

LabelMap SegmentStudyCt(const Volume& ct, Progress& progress, SegmentationReport* report) {
  ct.grid.Validate(ct.source);
  SubProgress search(progress, 0, 0.1);
  const FoundOrgan found = FindStudyOrgan(ct, search);
  SayWhatWasAssumed(ct, found, progress);
  SegmentationRequest request;
  request.preset = found.preset;
  // The organ was chosen because it stands out: hardly anything of its brightness can leak into it.
  OrganKnowledge knowledge = KnowledgeOf(found.preset);
  knowledge.neck_ratio = std::min(knowledge.neck_ratio, 0.5);
  knowledge.thin_mm = 2;
  knowledge.rib_gap_mm = 0;
  knowledge.follow_drift = false;
  return Segment(ct, knowledge, request, {found.seed_mm}, progress, report);
}

}  // namespace kerf
