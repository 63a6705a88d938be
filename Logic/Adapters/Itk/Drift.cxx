#include "Adapters/Itk/Drift.h"

#include <itkSmoothingRecursiveGaussianImageFilter.h>

#include <cmath>

#include "Adapters/Itk/ImageBridge.h"

namespace kerf {
namespace {

constexpr double kScale_mm = 15;      // longer ones lag behind where the brightness falls
constexpr double kInterior_mm = 6;    // rims hold partial volumes
constexpr double kSeedReach_mm = 15;  // a seed may lie in a vessel
constexpr double kMost_hu = 45;
constexpr float kLeastWeight = 0.01f;
constexpr int kMostRounds = 10;

ScalarField Smooth(const ScalarField& field) {
  using Image = itk_bridge::Image3<float>;
  auto filter = itk::SmoothingRecursiveGaussianImageFilter<Image, Image>::New();
  filter->SetInput(itk_bridge::ToItk<float>(field.grid, field.values));
  filter->SetSigma(kScale_mm);
  filter->Update();
  ScalarField out;
  out.grid = field.grid;
  out.values = itk_bridge::VoxelsOf<float>(filter->GetOutput());
  return out;
}

/// The connected interiors that a seed lies in or close to.
Mask AtSeeds(const Mask& interior, const std::vector<Vec3>& seeds) {
  const auto components = Components(interior, nullptr);
  const auto& grid = interior.grid;
  std::vector<int> own;
  for (const Vec3& seed : seeds) {
    double nearest = kSeedReach_mm;
    int best = 0;
    std::size_t at = 0;
    for (int k = 0; k < grid.size[2]; ++k)
      for (int j = 0; j < grid.size[1]; ++j)
        for (int i = 0; i < grid.size[0]; ++i, ++at) {
          if (!interior.values[at]) continue;
          const double distance = (grid.WorldFromIndex(Vec3(i, j, k)) - seed).norm();
          if (distance >= nearest) continue;
          nearest = distance;
          best = components.values[at];
        }
    if (best > 0) own.push_back(best);
  }
  Mask out(grid, 0);
  for (std::size_t i = 0; i < out.values.size(); ++i)
    out.values[i] = components.values[i] > 0 &&
                    std::find(own.begin(), own.end(), components.values[i]) != own.end();
  return out;
}

}  // namespace

ScalarField BrightnessDrift_hu(const ScalarField& image, const Tissue& tissue,
                               const std::vector<Vec3>& seeds, Progress& progress) {
  ScalarField drift(image.grid, 0.f);
  std::size_t before = 0;
  for (int round = 0; round < kMostRounds; ++round) {
    progress.ThrowIfCancelled();
    progress.Report(double(round) / kMostRounds, "brightness of the organ");
    Mask alike(image.grid, 0);
    for (std::size_t i = 0; i < image.values.size(); ++i) {
      const float hu = image.values[i] - drift.values[i];
      alike.values[i] = hu > tissue.low_hu && hu < tissue.high_hu;
    }
    const Mask organ = AtSeeds(Erode(alike, kInterior_mm), seeds);
    const std::size_t found = Count(organ);
    // As long as there is more of the organ to be followed.
    if (found < 100 || double(found) < 1.02 * double(before)) break;
    before = found;
    ScalarField weight(image.grid, 0.f), sum(image.grid, 0.f);
    for (std::size_t i = 0; i < image.values.size(); ++i)
      if (organ.values[i]) {
        weight.values[i] = 1;
        sum.values[i] = image.values[i] - float(tissue.mean_hu);
      }
    weight = Smooth(weight);
    sum = Smooth(sum);
    for (std::size_t i = 0; i < image.values.size(); ++i)
      drift.values[i] =
          weight.values[i] > kLeastWeight
              ? std::clamp(sum.values[i] / weight.values[i], float(-kMost_hu), float(kMost_hu))
              : 0.f;
  }
  return drift;
}

}  // namespace kerf
