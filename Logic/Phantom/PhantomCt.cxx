#include "Phantom/PhantomCt.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "Phantom/Noise.h"
#include "Phantom/PhantomShape.h"

namespace kerf {
namespace {

constexpr double kBlur_mm = 0.75;  ///< point spread and voxel size together, standard deviation
constexpr double kWhiteNoise_HU = 44.0;  ///< before the reconstruction kernel: about 17 HU after it
constexpr double kFatGap_mm = 4.0;

double Coverage(double distance_mm) {
  return 0.5 * std::erfc(distance_mm / (kBlur_mm * std::sqrt(2.0)));
}

double Tube(const Vec3& p, const Vec3& a, const Vec3& b, double radius) {
  const Vec3 ab = b - a;
  const double t = std::clamp((p - a).dot(ab) / ab.squaredNorm(), 0.0, 1.0);
  return (p - a - t * ab).norm() - radius;
}

double Blob(const Vec3& p, const Vec3& centre, const Vec3& radii) {
  const Vec3 q = p - centre;
  return (q.cwiseQuotient(radii).norm() - 1.0) * radii.minCoeff();
}

/// Distance in mm: the implicit value over its slope.
template <typename Function>
double Distance(const Function& f, const Vec3& p) {
  const double value = f(p);
  if (std::abs(value) > 6.0) return value;
  return value / std::max(NumericGradient(f, p, 0.1).norm(), 0.2);
}

double IntensityAt(const Vec3& p, double organ_mm, std::uint32_t seed) {
  double hu = -102.0 + 10.0 * FractalNoise(p / 9.0, 2, seed);
  auto blend = [&](double inside_hu, double distance) {
    const double c = Coverage(std::max(distance, kFatGap_mm - organ_mm));
    hu += c * (inside_hu - hu);
  };
  const double muscle = 58.0 + 12.0 * FractalNoise(p / 5.0, 2, seed + 3);
  blend(muscle,
        Tube(p, {-90, 16, -50}, {90, 22, -46}, 19.0) + 1.5 * ValueNoise(p / 14.0, seed + 4));
  blend(muscle, p.z() + 58.0 - 0.08 * p.y());
  const double spine = Tube(p, {-90, 66, -38}, {90, 74, -34}, 20.0);
  blend(480.0, spine);
  blend(190.0 + 60.0 * FractalNoise(p / 2.5, 2, seed + 5), spine + 2.2);
  blend(128.0, Blob(p, {54, -44, 8}, {34, 17, 27}));
  blend(150.0, Tube(p, {-90, 60, 2}, {90, 62, 0}, 8.5));
  const double bowel =
      Tube(p, {-70, -30, 30}, {10, -46, 36}, 13.0) + 2.0 * ValueNoise(p / 9.0, seed + 6);
  blend(42.0, bowel);
  blend(-860.0, bowel + 3.0);

  if (organ_mm < 6.0) {
    const double parenchyma = 165.0 + 14.0 * FractalNoise(p / 6.0, 3, seed + 7);
    hu += Coverage(organ_mm) * (parenchyma - hu);
    const double lesion = 82.0 + 16.0 * FractalNoise(p / 3.0, 2, seed + 8);
    hu += Coverage(Distance(KidneyTumour, p)) * (lesion - hu);
    hu += Coverage(Distance(KidneyCalyces, p)) * (480.0 - hu);
  }
  return hu;
}

}  // namespace

PhantomCt MakePhantomCt(const PhantomSetup& setup, Progress& progress) {
  Vec3 low = Vec3::Constant(1e9), high = Vec3::Constant(-1e9);
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 p((corner & 1) ? 53 : -53, (corner & 2) ? 29 : -29, (corner & 4) ? 24 : -24);
    const Vec3 world = setup.world_from_organ * p;
    low = low.cwiseMin(world);
    high = high.cwiseMax(world);
  }
  GridGeometry grid;
  grid.spacing_mm = Vec3(0.95, 0.95, 1.25);
  grid.origin_mm = low - Vec3::Constant(9.0);
  for (int k = 0; k < 3; ++k)
    grid.size[k] =
        static_cast<int>(std::ceil((high[k] + 9.0 - grid.origin_mm[k]) / grid.spacing_mm[k]));

  auto voxels = std::make_shared<std::vector<std::int16_t>>(grid.VoxelCount());
  auto labels = std::make_shared<std::vector<std::uint8_t>>(grid.VoxelCount(), std::uint8_t(0));
  const Eigen::Isometry3d organ_from_world = setup.world_from_organ.inverse();
  const std::uint32_t noise = setup.seed * 7919U + 17U;
  // Reconstruction kernel 1-2-1 in the slice: what makes CT noise grainy rather than white.
  auto grain = [&](int i, int j, int k) {
    double sum = 0.0;
    for (int dj = -1; dj <= 1; ++dj)
      for (int di = -1; di <= 1; ++di)
        sum += (2 - std::abs(di)) * (2 - std::abs(dj)) *
               NormalFromHash(Hash(static_cast<std::uint32_t>(i + di),
                                   static_cast<std::uint32_t>(j + dj),
                                   static_cast<std::uint32_t>(k), noise));
    return kWhiteNoise_HU * sum / 16.0;
  };
  progress.ThrowIfCancelled();
  tbb::parallel_for(0, grid.size[2], [&](int k) {
    for (int j = 0; j < grid.size[1]; ++j)
      for (int i = 0; i < grid.size[0]; ++i) {
        const Vec3 p = organ_from_world * grid.WorldFromIndex(Vec3(i, j, k));
        const std::size_t at = grid.Offset(i, j, k);
        const double organ_mm = Distance(KidneyOrgan, p);
        const double hu = IntensityAt(p, organ_mm, setup.seed) + grain(i, j, k);
        (*voxels)[at] = static_cast<std::int16_t>(std::lround(std::clamp(hu, -1024.0, 3071.0)));
        if (organ_mm < 0.0)
          (*labels)[at] = static_cast<std::uint8_t>(KidneyCalyces(p) < 0.0  ? Label::Internal
                                                    : KidneyTumour(p) < 0.0 ? Label::Tumour
                                                                            : Label::Organ);
      }
  });
  PhantomCt out;
  out.ct.grid = out.labels.grid = grid;
  out.ct.voxels = voxels;
  out.ct.source = out.labels.source = "phantom";
  out.ct.metadata["Modality"] = "CT";
  out.labels.voxels = labels;
  out.labels.names = {{1, "organ"}, {2, "tumour"}, {3, "internal"}};
  return out;
}

}  // namespace kerf
