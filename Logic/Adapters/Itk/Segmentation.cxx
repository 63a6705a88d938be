#include "Adapters/Itk/Segmentation.h"

#include <fmt/format.h>

#include "Adapters/Itk/InnerStructures.h"
#include "Adapters/Itk/OrganRegion.h"
#include "Adapters/Itk/OrganSearch.h"
#include "Adapters/Itk/SegmentationCheck.h"
#include "Adapters/Itk/WorkingGrid.h"
#include "Core/Errors.h"

namespace kerf {
namespace {

std::vector<Vec3> PointsOf(const std::vector<Seed>& seeds, SeedKind kind) {
  std::vector<Vec3> points;
  for (const Seed& seed : seeds)
    if (seed.kind == kind) points.push_back(seed.position_mm);
  return points;
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
  Mask found = region.mask;
  region.mask = FillHoles(LargestComponent(found));
  for (std::size_t i = 0; i < found.values.size(); ++i)
    if (inner.apart.values[i]) found.values[i] = 1;
  for (std::size_t i = 0; i < region.mask.values.size(); ++i)
    if (!region.mask.values[i]) inner.tumour.values[i] = inner.internal.values[i] = 0;
  SegmentationReport own;
  SegmentationReport& filled = report ? *report : own;
  filled = SegmentationReport();
  CheckSegmentation(ct, knowledge, region, inner, &filled);
  CheckLeftOut(found, region.mask, knowledge, request.seeds, &filled);
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
