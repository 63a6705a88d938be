#include "Adapters/Itk/InnerStructures.h"

#include <fmt/format.h>

#include <cmath>

#include "Adapters/Itk/Contour.h"
#include "Adapters/Itk/Outline.h"
#include "Adapters/Itk/Parts.h"
#include "Adapters/Itk/Statistics.h"
#include "Adapters/Itk/WorkingGrid.h"
#include "Core/Errors.h"

namespace kerf {
namespace {

constexpr float kContrastMost = 3000;  // filled calyces are brighter than bone
constexpr double kSoftTissueHu = -20;  // anything darker is fat or air, no tumour

/// What every step looks at.
struct Scene {
  ScalarField measured;  ///< HU on the organ's grid, brightness drift taken off
  ScalarField image;     ///< the same, denoised
  ScalarField inside;    ///< depth in the organ, mm
  double mean = 0, noise = 0;
  double voxel_mm = 1;
};

std::size_t VoxelsOf_ml(const GridGeometry& grid, double ml) {
  return std::size_t(std::ceil(ml * 1000 / grid.VoxelVolume_mm3()));
}

Mask Select(const Scene& scene, double low, double high, double least_depth_mm) {
  Mask out(scene.image.grid, 0);
  for (std::size_t i = 0; i < out.values.size(); ++i)
    out.values[i] = scene.image.values[i] > low && scene.image.values[i] < high &&
                    scene.inside.values[i] >= least_depth_mm;
  return out;
}

Mask KeepLargerThan(const Mask& mask, std::size_t least) {
  std::vector<std::size_t> sizes;
  const auto components = Components(mask, &sizes);
  Mask out(mask.grid, 0);
  for (std::size_t i = 0; i < out.values.size(); ++i) {
    const int c = components.values[i];
    out.values[i] = c > 0 && sizes[std::size_t(c - 1)] >= least;
  }
  return out;
}

std::vector<float> ValuesIn(const ScalarField& image, const Mask& mask) {
  std::vector<float> values;
  for (std::size_t i = 0; i < mask.values.size(); ++i)
    if (mask.values[i]) values.push_back(image.values[i]);
  return values;
}

void Join(Mask* into, const Mask& other) {
  for (std::size_t i = 0; i < into->values.size(); ++i)
    into->values[i] = into->values[i] || other.values[i];
}

Scene MakeScene(const Volume& ct, const Mask& organ, const Tissue& tissue,
                const ScalarField& drift_hu, Progress& progress) {
  Scene scene;
  scene.measured = Sample(ct, organ.grid, progress, kContrastMost);
  const ScalarField drift = Resample(drift_hu, organ.grid, 0.f);
  for (std::size_t i = 0; i < drift.values.size(); ++i) scene.measured.values[i] -= drift.values[i];
  scene.image = Denoise(scene.measured, 3, progress);
  scene.inside = SignedDistance_mm(organ);
  scene.voxel_mm = organ.grid.spacing_mm.maxCoeff();
  std::vector<float> parenchyma =
      ValuesIn(scene.image, Select(scene, tissue.low_hu, tissue.high_hu, 2 * scene.voxel_mm));
  if (parenchyma.size() < 100)
    parenchyma = ValuesIn(scene.image, Select(scene, tissue.low_hu, tissue.high_hu, 0));
  scene.mean = parenchyma.empty() ? tissue.mean_hu : Median(parenchyma);
  scene.noise = parenchyma.empty() ? 10 : Spread(parenchyma, scene.mean);
  return scene;
}

/// Face-connected parts of a mask, numbered from 0; −1 outside.
struct Connected {
  Field<std::int32_t> part;
  int count = 0;
};
Connected ConnectedParts(const Mask& mask) {
  std::vector<std::size_t> sizes;
  Connected found{Components(mask, &sizes), 0};
  for (std::int32_t& c : found.part.values) --c;
  found.count = int(sizes.size());
  return found;
}

/// Fraction of the shell around a part that is organ.
std::vector<double> EnclosedFractions(const Field<std::int32_t>& part, int parts,
                                      const Mask& organ_and_gap) {
  std::vector<double> touching(parts, 0), faces(parts, 0);
  const auto& size = part.grid.size;
  const std::ptrdiff_t stride[3] = {1, size[0], std::ptrdiff_t(size[0]) * size[1]};
  std::size_t at = 0;
  for (int k = 0; k < size[2]; ++k)
    for (int j = 0; j < size[1]; ++j)
      for (int i = 0; i < size[0]; ++i, ++at) {
        const int own = part.values[at];
        if (own < 0) continue;
        const int index[3] = {i, j, k};
        for (int axis = 0; axis < 3; ++axis)
          for (const int step : {-1, 1}) {
            const int next = index[axis] + step;
            const double area = 1 / part.grid.spacing_mm[axis];
            if (next < 0 || next >= size[axis]) {
              faces[own] += area;
              continue;
            }
            const std::size_t to = std::size_t(std::ptrdiff_t(at) + step * stride[axis]);
            if (part.values[to] == own) continue;
            faces[own] += area;
            if (organ_and_gap.values[to]) touching[own] += area;
          }
      }
  for (int p = 0; p < parts; ++p) touching[p] = faces[p] > 0 ? touching[p] / faces[p] : 0;
  return touching;
}

/// The largest component; the others join `apart`.
Mask KeepLargest(const Mask& mask, Mask* apart) {
  const Mask largest = LargestComponent(mask);
  for (std::size_t i = 0; i < mask.values.size(); ++i)
    if (mask.values[i] && !largest.values[i]) apart->values[i] = 1;
  return largest;
}

/// Darker soft tissue outside, largely enclosed by the organ: a tumour that bulges out of it.
bool JoinOutgrowths(const Scene& scene, const OrganKnowledge& knowledge, const Tissue& tissue,
                    Mask* organ, Mask* apart, Progress& progress) {
  Mask outside(organ->grid, 0);
  const double boundary = std::max(kSoftTissueHu, 0.5 * (kSoftTissueHu + scene.mean) - 40);
  for (std::size_t i = 0; i < outside.values.size(); ++i)
    outside.values[i] = !organ->values[i] && scene.image.values[i] > boundary &&
                        scene.image.values[i] < tissue.high_hu;
  outside = Open(outside, 1.5 * scene.voxel_mm);
  progress.ThrowIfCancelled();
  const auto part = DivideAtNecks(SignedDistance_mm(outside), 0.75, 0.2 * scene.voxel_mm);
  const int parts = 1 + *std::max_element(part.values.begin(), part.values.end());
  if (parts <= 0) return false;
  const Mask near = Dilate(*organ, 2 * scene.voxel_mm);
  const auto enclosed = EnclosedFractions(part, parts, near);
  std::vector<std::size_t> size(parts, 0);
  for (const int p : part.values)
    if (p >= 0) ++size[p];
  const std::size_t least = VoxelsOf_ml(organ->grid, knowledge.tumour.least_ml);
  const std::size_t most = Count(*organ) / 2;
  std::vector<bool> take(parts);
  bool any = false;
  for (int p = 0; p < parts; ++p) {
    take[p] = size[p] >= least && size[p] <= most && enclosed[p] >= knowledge.tumour.enclosed;
    any = any || take[p];
  }
  if (!any) return false;
  Mask grown = *organ;
  for (std::size_t i = 0; i < grown.values.size(); ++i)
    if (part.values[i] >= 0 && take[part.values[i]]) grown.values[i] = 1;
  *organ = FillHoles(Close(grown, 2 * scene.voxel_mm));
  // The outgrowth was opened: its rim and the crease beside it are still missing.
  for (int round = 0; round < 2; ++round) *organ = AtHalfContrast(scene.image, *organ);
  *organ = FillHoles(KeepLargest(*organ, apart));
  return true;
}

/// Contrast agent in a pocket of the organ belongs to it, though the way out is open.
void JoinPockets(const Scene& scene, const OrganKnowledge& knowledge, Mask* organ) {
  constexpr double kPocket_mm = 8, kEnclosed = 0.75;
  const Mask closed = Close(*organ, kPocket_mm);
  Mask pocket(organ->grid, 0);
  const double bright = scene.mean + std::max(knowledge.internal.contrast_hu, 3.5 * scene.noise);
  for (std::size_t i = 0; i < pocket.values.size(); ++i)
    pocket.values[i] = closed.values[i] && !organ->values[i] && scene.image.values[i] > bright;
  const Connected found = ConnectedParts(pocket);
  const auto enclosed = EnclosedFractions(found.part, found.count, *organ);
  bool any = false;
  for (std::size_t i = 0; i < pocket.values.size(); ++i) {
    const int p = found.part.values[i];
    if (p < 0 || enclosed[std::size_t(p)] < kEnclosed) continue;
    organ->values[i] = 1;
    any = true;
  }
  if (any) *organ = FillHoles(*organ);
}

/// Bright bodies that lie on the organ rather than in it are ribs and cartilage. What is left is
/// opened: rims between two of them would pinch the mesh.
void RemoveLeaning(Mask* bright, Mask* organ, Mask* apart) {
  constexpr double kEnclosed = 0.75;
  const Connected found = ConnectedParts(*bright);
  const auto enclosed = EnclosedFractions(found.part, found.count, *organ);
  bool any = false;
  for (std::size_t i = 0; i < bright->values.size(); ++i) {
    const int p = found.part.values[i];
    if (p < 0 || enclosed[std::size_t(p)] >= kEnclosed) continue;
    bright->values[i] = organ->values[i] = 0;
    any = true;
  }
  if (any) *organ = FillHoles(KeepLargest(Open(*organ, organ->grid.spacing_mm.maxCoeff()), apart));
}

/// Bodies on one side of the parenchyma's HU: found where the difference is certain, outlined at
/// half contrast.
Mask Bodies(const Scene& scene, const OrganKnowledge::Blob& blob, bool bright, double open_mm) {
  const double difference = std::max(blob.contrast_hu, 3.5 * scene.noise);
  const double low = bright ? scene.mean + difference : kSoftTissueHu;
  const double high = bright ? 1e9 : scene.mean - difference;
  Mask core = Select(scene, low, high, 2 * scene.voxel_mm);
  if (open_mm > 0) core = Open(core, open_mm);
  core = KeepLargerThan(core, VoxelsOf_ml(core.grid, 0.4 * blob.least_ml));
  if (Count(core) == 0) return core;
  // The level is that of the bodies' middle: partial volumes at their rims do not count.
  const double level = Quantile(ValuesIn(scene.image, core), bright ? 0.75 : 0.35);
  const double half = 0.5 * (scene.mean + level);
  const Mask all = bright ? Select(scene, half, 1e9, 0) : Select(scene, kSoftTissueHu, half, 0);
  Mask body = core;
  if (bright) {
    body = GeodesicGrow(core, all, 1e6);
  } else {
    // The organ's own rim is as dark as a tumour: reached from within the tumour, not along it.
    Mask deep = all;
    for (std::size_t i = 0; i < deep.values.size(); ++i)
      deep.values[i] = deep.values[i] && scene.inside.values[i] >= 1.5 * scene.voxel_mm;
    body = GeodesicGrow(GeodesicGrow(core, deep, 6 * scene.voxel_mm), all, 2.5 * scene.voxel_mm);
  }
  for (std::size_t i = 0; i < body.values.size(); ++i)
    body.values[i] = body.values[i] && all.values[i];
  return KeepLargerThan(body, VoxelsOf_ml(core.grid, blob.least_ml));
}

/// The body that a person points at, on the seed's side of half contrast.
Mask SeededBody(const Scene& scene, const Vec3& seed_mm, const char* kind, const Mask& organ) {
  const Vec3 index = organ.grid.IndexFromWorld(seed_mm);
  const std::string where = fmt::format("{} seed at ({:.1f}, {:.1f}, {:.1f}) mm", kind, seed_mm[0],
                                        seed_mm[1], seed_mm[2]);
  Eigen::Vector3i at;
  for (int a = 0; a < 3; ++a) {
    at[a] = int(std::lround(index[a]));
    if (at[a] < 0 || at[a] >= organ.grid.size[a])
      throw InputError("seeds", where, "lies far outside the organ that was found");
  }
  std::vector<float> near;
  for (int k = -1; k <= 1; ++k)
    for (int j = -1; j <= 1; ++j)
      for (int i = -1; i <= 1; ++i) {
        const Eigen::Vector3i p = at + Eigen::Vector3i(i, j, k);
        if (p.minCoeff() >= 0 && (organ.grid.size - p).minCoeff() > 0)
          near.push_back(scene.image.values[organ.grid.Offset(p[0], p[1], p[2])]);
      }
  const double level = Median(near);
  if (std::abs(level - scene.mean) < std::max(8.0, 1.5 * scene.noise))
    throw InputError(
        "seeds", where,
        fmt::format("cannot be told from the parenchyma: {:.0f} and {:.0f} HU", level, scene.mean));
  const double half = 0.5 * (scene.mean + level);
  Mask candidate(organ.grid, 0);
  for (std::size_t i = 0; i < candidate.values.size(); ++i) {
    const float v = scene.image.values[i];
    candidate.values[i] =
        (level > scene.mean ? v > half : v > std::min(kSoftTissueHu, level - 40) && v < half) &&
        scene.inside.values[i] > -30;
  }
  candidate.values[organ.grid.Offset(at[0], at[1], at[2])] = 1;
  const bool thin = level > scene.mean;  // vessels and calyces branch: no necks there
  if (thin) {
    const auto components = Components(candidate, nullptr);
    const int own = components.values[organ.grid.Offset(at[0], at[1], at[2])];
    for (std::size_t i = 0; i < candidate.values.size(); ++i)
      candidate.values[i] = components.values[i] == own && scene.inside.values[i] >= 0;
    return candidate;
  }
  const auto part = DivideAtNecks(SignedDistance_mm(candidate), 0.7, 0.2 * scene.voxel_mm);
  const int own = part.values[organ.grid.Offset(at[0], at[1], at[2])];
  for (std::size_t i = 0; i < candidate.values.size(); ++i)
    candidate.values[i] = part.values[i] == own;
  return Open(candidate, scene.voxel_mm);
}

}  // namespace

InnerStructures FindInnerStructures(const Volume& ct, const OrganKnowledge& knowledge,
                                    const Tissue& tissue, const ScalarField& drift_hu,
                                    const std::vector<Vec3>& tumour_seeds,
                                    const std::vector<Vec3>& internal_seeds, Mask* organ,
                                    Progress& progress) {
  SubProgress first(progress, 0, 0.5);
  Scene scene = MakeScene(ct, *organ, tissue, drift_hu, first);
  progress.Report(0.5, "inner structures");
  InnerStructures found{Mask(organ->grid, 0), Mask(organ->grid, 0), Mask(organ->grid, 0)};
  if (tumour_seeds.empty() &&
      JoinOutgrowths(scene, knowledge, tissue, organ, &found.apart, progress))
    scene.inside = SignedDistance_mm(*organ);
  progress.ThrowIfCancelled();
  if (internal_seeds.empty()) {
    JoinPockets(scene, knowledge, organ);
    scene.inside = SignedDistance_mm(*organ);
  }

  if (internal_seeds.empty()) {
    found.internal = Bodies(scene, knowledge.internal, true, 0);
    RemoveLeaning(&found.internal, organ, &found.apart);
  } else {
    for (const Vec3& seed : internal_seeds)
      Join(&found.internal, SeededBody(scene, seed, "internal", *organ));
  }
  found.internal = OutlineBranching(scene.measured, found.internal, *organ);
  progress.ThrowIfCancelled();
  if (tumour_seeds.empty()) {
    found.tumour = Bodies(scene, knowledge.tumour, false, scene.voxel_mm);
  } else {
    for (const Vec3& seed : tumour_seeds)
      Join(&found.tumour, SeededBody(scene, seed, "tumour", *organ));
    Join(organ, found.tumour);
    *organ = FillHoles(*organ);
  }
  progress.ThrowIfCancelled();
  found.tumour = OutlineCompact(scene.measured, found.tumour, *organ, found.internal);
  for (std::size_t i = 0; i < organ->values.size(); ++i)
    if (found.internal.values[i]) found.tumour.values[i] = 0;
  return found;
}

}  // namespace kerf
