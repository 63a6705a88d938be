#include "Adapters/Itk/OrganRegion.h"

#include <fmt/format.h>

#include <cmath>

#include "Adapters/Itk/Contour.h"
#include "Adapters/Itk/Drift.h"
#include "Adapters/Itk/Parts.h"
#include "Adapters/Itk/RandomWalker.h"
#include "Adapters/Itk/WorkingGrid.h"
#include "Core/Errors.h"

namespace kerf {
namespace {

constexpr double kFatHu = -90;  // what surrounds abdominal organs
constexpr double kLargestFineGrid = 12e6;
constexpr double kThin = 0.4;  // of the half-thickness: a slender organ is not thin

/// Part at the seed; the nearest one where the seed sits in a gap of noise.
int PartAt(const Field<std::int32_t>& part, const Vec3& seed_mm) {
  const Eigen::Vector3i at = NearestIndex(part.grid, seed_mm);
  for (int radius = 0; radius < 6; ++radius) {
    int best = -1;
    double nearest = 1e9;
    for (int k = -radius; k <= radius; ++k)
      for (int j = -radius; j <= radius; ++j)
        for (int i = -radius; i <= radius; ++i) {
          const Eigen::Vector3i p = at + Eigen::Vector3i(i, j, k);
          if (p.minCoeff() < 0 || (part.grid.size - p).minCoeff() <= 0) continue;
          const int found = part.values[part.grid.Offset(p[0], p[1], p[2])];
          const double distance = Vec3(i, j, k).norm();
          if (found >= 0 && distance < nearest) {
            nearest = distance;
            best = found;
          }
        }
    if (best >= 0) return best;
  }
  return -1;
}

/// What certainly is something else: fat, air and bone, and a person's background seeds.
bool IsOther(float hu, const Tissue& tissue) {
  const double boundary = 0.5 * (tissue.mean_hu + kFatHu);
  return hu < boundary - 25 || hu > tissue.high_hu + 90;
}

/// Largest distance to the body's boundary.
double HalfThickness_mm(const Mask& body, const ScalarField& depth_mm) {
  double most = 0;
  for (std::size_t i = 0; i < body.values.size(); ++i)
    if (body.values[i]) most = std::max(most, double(depth_mm.values[i]));
  return most;
}

/// Tubes and sheets have no neck: what is thinner than 2·thin_mm and leads away from the organ
/// goes.
Mask WithoutThin(const Mask& body, double thin_mm) {
  std::vector<std::size_t> sizes;
  const auto thick = Components(AtLeast(SignedDistance_mm(body), float(thin_mm)), &sizes);
  if (sizes.empty()) return body;
  Mask kept(body.grid, 0);
  for (std::size_t i = 0; i < kept.values.size(); ++i) {
    const int c = thick.values[i];
    kept.values[i] = c > 0 && sizes[std::size_t(c - 1)] * 20 >= sizes.front();
  }
  return GeodesicGrow(kept, body, 1.8 * thin_mm);
}

/// Ribs and the muscle between them, which without contrast is as bright as a liver: what is bright
/// and slender (no spine, no contrast-filled organ), closed across the gaps. @param image not
/// denoised: that melts ribs
Mask ChestWall(const ScalarField& image, const Tissue& tissue, double gap_mm) {
  constexpr double kBoneHu = 150, kMostHalfThickness_mm = 8;
  const double least = std::max(kBoneHu, tissue.high_hu + 75);
  Mask bones = AtLeast(image, float(least));
  const Mask thick = Dilate(Erode(bones, kMostHalfThickness_mm), kMostHalfThickness_mm + 3);
  for (std::size_t i = 0; i < bones.values.size(); ++i)
    if (thick.values[i]) bones.values[i] = 0;
  return Close(bones, 0.5 * gap_mm);
}

/// Tissue alike, divided at its necks.
struct Divided {
  ScalarField depth_mm;
  Field<std::int32_t> part;
  Mask own;  ///< the parts at the seeds
};

Divided Divide(const ScalarField& image, const Mask& wall, const Tissue& tissue,
               const OrganKnowledge& knowledge, const std::vector<Vec3>& seeds,
               const std::vector<Vec3>& background) {
  Mask same = Alike(image, tissue);
  const Mask closed = Close(same, knowledge.closing_mm);
  for (std::size_t i = 0; i < same.values.size(); ++i)
    if (closed.values[i] && image.values[i] > tissue.low_hu - 30 &&
        image.values[i] < tissue.high_hu + 30)
      same.values[i] = 1;
  same = FillHoles(same);
  for (const Vec3& point : background)
    for (std::size_t i = 0, n = same.values.size(); i < n; ++i) {
      const auto& s = image.grid.size;
      const Vec3 index(double(i % s[0]), double(i / s[0] % s[1]),
                       double(i / (std::size_t(s[0]) * s[1])));
      if ((image.grid.WorldFromIndex(index) - point).norm() < 3) same.values[i] = 0;
    }
  for (std::size_t i = 0; i < same.values.size(); ++i)
    if (wall.values[i]) same.values[i] = 0;
  Divided divided;
  divided.depth_mm = SignedDistance_mm(same);
  divided.part =
      DivideAtNecks(divided.depth_mm, knowledge.neck_ratio, 0.2 * image.grid.spacing_mm[0]);
  std::vector<int> own;
  for (const Vec3& seed : seeds) own.push_back(PartAt(divided.part, seed));
  divided.own = Mask(image.grid, 0);
  for (std::size_t i = 0; i < same.values.size(); ++i) {
    const int part = divided.part.values[i];
    divided.own.values[i] = part >= 0 && std::find(own.begin(), own.end(), part) != own.end();
  }
  return divided;
}

/// @param tissue learned around the seeds; comes back as learned from what was found
Mask CoarseOrgan(const ScalarField& image, const Mask& wall, const OrganKnowledge& knowledge,
                 const std::vector<Vec3>& seeds, const std::vector<Vec3>& background,
                 Tissue* tissue, Progress& progress) {
  progress.Report(0.1, "dividing at necks");
  Divided divided = Divide(image, wall, *tissue, knowledge, seeds, background);
  for (int round = 0; round < 3; ++round) {
    progress.ThrowIfCancelled();
    if (!LearnTissueAgain(image, divided.own, knowledge, tissue)) break;
    divided = Divide(image, wall, *tissue, knowledge, seeds, background);
  }
  const auto& [depth, part, own] = divided;
  Mask core = own;
  if (Count(core) == 0) return core;
  progress.ThrowIfCancelled();
  core = WithoutThin(core, std::min(knowledge.thin_mm, kThin * HalfThickness_mm(core, depth)));

  const ScalarField core_depth = SignedDistance_mm(core);
  Mask markers(image.grid, 0);
  const double spacing = image.grid.spacing_mm[0];
  for (std::size_t i = 0; i < core.values.size(); ++i) {
    const bool other_part = part.values[i] >= 0 && !core.values[i];
    if (core.values[i] && core_depth.values[i] >= spacing)
      markers.values[i] = 2;
    else if (wall.values[i] || (other_part && depth.values[i] > 0.75 * spacing) ||
             core_depth.values[i] < -4 * spacing || IsOther(image.values[i], *tissue))
      markers.values[i] = 1;
  }
  SubProgress walking(progress, 0.5, 1);
  return AtLeast(RandomWalk(image, markers, {}, walking), 0.5f);
}

/// The coarse organ's boundary found again within a band on the CT's voxels.
Mask Refine(const Volume& ct, const Mask& coarse, const Tissue& tissue,
            const OrganKnowledge& knowledge, Progress& progress) {
  Eigen::Vector3i low, high;
  BoundingBox(coarse, 0, &low, &high);
  // Room for a tumour that grows out of the organ.
  const double margin = 4 * coarse.grid.spacing_mm[0] + 12;
  const Vec3 a = ct.grid.IndexFromWorld(coarse.grid.WorldFromIndex(low.cast<double>()));
  const Vec3 b = ct.grid.IndexFromWorld(coarse.grid.WorldFromIndex(high.cast<double>()));
  Eigen::Vector3i from, to;
  for (int axis = 0; axis < 3; ++axis) {
    const double voxels = margin / ct.grid.spacing_mm[axis];
    from[axis] = int(std::floor(std::min(a[axis], b[axis]) - voxels));
    to[axis] = int(std::ceil(std::max(a[axis], b[axis]) + voxels));
  }
  const GridGeometry crop = CropGrid(ct.grid, from, to);
  // Very fine scans are halved in the plane: the boundary is interpolated back.
  GridGeometry fine = crop;
  for (int axis = 0; axis < 3 && double(fine.VoxelCount()) > kLargestFineGrid; ++axis) {
    if (fine.size[axis] < 64) continue;
    fine.size[axis] = (fine.size[axis] + 1) / 2;
    fine.spacing_mm[axis] *= 2;
  }
  // Coarse scans are doubled: half of what a voxel holds may be the neighbour.
  for (int axis = 0; axis < 3; ++axis)
    if (fine.spacing_mm[axis] > 2) {
      fine.size[axis] = 2 * fine.size[axis] - 1;
      fine.spacing_mm[axis] /= 2;
    }
  ScalarField image = Sample(ct, fine, progress);
  SubProgress denoising(progress, 0, 0.3);
  image = Denoise(image, 5, denoising);
  const ScalarField coarse_inside = SignedDistance_mm(coarse);
  ScalarField inside = Resample(coarse_inside, fine, -1e3f);
  const double band = 1.5 * coarse.grid.spacing_mm[0];
  Mask markers(fine, 0);
  for (std::size_t i = 0; i < inside.values.size(); ++i) {
    if (inside.values[i] > band)
      markers.values[i] = 2;
    else if (inside.values[i] < -band || IsOther(image.values[i], tissue))
      markers.values[i] = 1;
  }
  SubProgress walking(progress, 0.3, 0.6);
  Mask organ = AtLeast(RandomWalk(image, markers, {}, walking), 0.5f);
  SubProgress snapping(progress, 0.6, 1);
  organ = FillHoles(LargestComponent(organ));
  const ScalarField snapped =
      SnapToEdges(EdgeStrength(image, snapping), SignedDistance_mm(organ), 10, snapping);
  const Mask settled = FillHoles(LargestComponent(AtHalfContrast(image, AtLeast(snapped, 0.f))));
  if (fine.size == crop.size) return settled;
  return FillHoles(
      LargestComponent(AtLeast(Resample(SignedDistance_mm(settled), crop, -1e3f), 0.f)));
}

}  // namespace

OrganRegion FindOrgan(const Volume& ct, const OrganKnowledge& knowledge,
                      const std::vector<Vec3>& organ, const std::vector<Vec3>& background,
                      const std::string& seeds_source, Progress& progress) {
  Vec3 center = Vec3::Zero();
  for (const Vec3& seed : organ) center += seed / double(organ.size());
  double reach = knowledge.reach_mm;
  for (const Vec3& seed : organ)
    reach = std::max(reach, (seed - center).cwiseAbs().maxCoeff() + 0.7 * knowledge.reach_mm);
  const GridGeometry grid = WorkingGrid(ct.grid, center, reach, knowledge.working_spacing_mm);
  SubProgress coarse_part(progress, 0, 0.5), fine_part(progress, 0.5, 1);
  const ScalarField raw = Sample(ct, grid, coarse_part);
  SubProgress denoising(coarse_part, 0, 0.3);
  ScalarField image = Denoise(raw, 15, denoising);

  OrganRegion region;
  region.tissue = LearnTissue(image, knowledge, organ, seeds_source);
  SubProgress following(coarse_part, 0.3, 0.4), dividing(coarse_part, 0.4, 1);
  region.drift_hu = knowledge.follow_drift
                        ? BrightnessDrift_hu(image, region.tissue, organ, following)
                        : ScalarField(grid, 0.f);
  for (std::size_t i = 0; i < image.values.size(); ++i)
    image.values[i] -= region.drift_hu.values[i];
  const Mask wall = knowledge.rib_gap_mm > 0 ? ChestWall(raw, region.tissue, knowledge.rib_gap_mm)
                                             : Mask(grid, 0);
  const Mask coarse =
      CoarseOrgan(image, wall, knowledge, organ, background, &region.tissue, dividing);
  if (Count(coarse) == 0)
    throw InputError(
        seeds_source, "organ seed",
        fmt::format("no connected tissue of {:.0f} HU around it", region.tissue.mean_hu));
  region.alike = Alike(image, region.tissue);
  for (std::size_t i = 0; i < wall.values.size(); ++i)
    if (wall.values[i]) region.alike.values[i] = 0;
  region.mask = Refine(ct, coarse, region.tissue, knowledge, fine_part);
  if (Count(region.mask) == 0)
    throw InputError(seeds_source, "organ seed", "no organ boundary was found around it");
  return region;
}

double OpenShare(const Mask& organ, const Mask& alike) {
  constexpr double kFrom_mm = 3, kTo_mm = 5;  // beyond what partial volumes blur
  const ScalarField inside = Resample(SignedDistance_mm(organ), alike.grid, -1e3f);
  std::size_t around = 0, open = 0;
  for (std::size_t i = 0; i < inside.values.size(); ++i) {
    if (inside.values[i] > -kFrom_mm || inside.values[i] < -kTo_mm) continue;
    ++around;
    open += alike.values[i];
  }
  return around == 0 ? 0 : double(open) / double(around);
}

}  // namespace kerf
