#include "Adapters/Itk/Tissue.h"

#include <fmt/format.h>

#include <cmath>

#include "Adapters/Itk/Statistics.h"
#include "Adapters/Itk/WorkingGrid.h"
#include "Core/Errors.h"

namespace kerf {
namespace {

constexpr double kMuscleHu = 60;  // what organs touch, at its brightest without contrast

std::vector<float> BallValues(const ScalarField& image, const Vec3& center_mm, double radius_mm,
                              const Mask* within) {
  const auto& grid = image.grid;
  const Eigen::Vector3i center = NearestIndex(grid, center_mm);
  Eigen::Vector3i reach;
  for (int a = 0; a < 3; ++a) reach[a] = int(radius_mm / grid.spacing_mm[a]);
  std::vector<float> values;
  for (int k = -reach[2]; k <= reach[2]; ++k)
    for (int j = -reach[1]; j <= reach[1]; ++j)
      for (int i = -reach[0]; i <= reach[0]; ++i) {
        const Vec3 offset = Vec3(i, j, k).cwiseProduct(grid.spacing_mm);
        const Eigen::Vector3i at = center + Eigen::Vector3i(i, j, k);
        if (offset.norm() > radius_mm || at.minCoeff() < 0 || (grid.size - at).minCoeff() <= 0)
          continue;
        const std::size_t o = grid.Offset(at[0], at[1], at[2]);
        if (!within || within->values[o]) values.push_back(image.values[o]);
      }
  return values;
}

void SetWindow(const OrganKnowledge& knowledge, double noise, Tissue* tissue) {
  // An enhanced organ stands out from everything by more than the noise: allow as much.
  const double enhanced = 0.35 * (tissue->mean_hu - kMuscleHu);
  tissue->low_hu = tissue->mean_hu - std::max({knowledge.window_hu[0], 3 * noise, enhanced});
  tissue->high_hu = tissue->mean_hu + std::max({knowledge.window_hu[1], 3 * noise, enhanced});
}

/// Noise of tissue alike within 25 mm of the seeds: from differences between voxels 6 mm apart, so
/// that a neighbour of nearly the same brightness does not count as noise.
double LocalNoise(const ScalarField& image, const Mask& same, const std::vector<Vec3>& seeds) {
  constexpr double kReach_mm = 25, kApart_mm = 6;
  const auto& grid = image.grid;
  const int apart = std::max(1, int(std::lround(kApart_mm / grid.spacing_mm[0])));
  const int reach = int(kReach_mm / grid.spacing_mm[0]);
  std::vector<float> differences;
  for (const Vec3& seed : seeds) {
    const Eigen::Vector3i center = NearestIndex(grid, seed);
    for (int k = -reach; k <= reach; ++k)
      for (int j = -reach; j <= reach; ++j)
        for (int i = -reach; i <= reach; ++i) {
          const Eigen::Vector3i at = center + Eigen::Vector3i(i, j, k);
          if (i * i + j * j + k * k > reach * reach || at.minCoeff() < 0 ||
              (grid.size - at).minCoeff() <= apart)
            continue;
          const std::size_t o = grid.Offset(at[0], at[1], at[2]);
          if (!same.values[o]) continue;
          for (int axis = 0; axis < 3; ++axis) {
            const Eigen::Vector3i other = at + apart * Eigen::Vector3i::Unit(axis);
            const std::size_t q = grid.Offset(other[0], other[1], other[2]);
            if (same.values[q]) differences.push_back(image.values[o] - image.values[q]);
          }
        }
  }
  return differences.empty() ? 0 : Spread(differences, 0) / std::sqrt(2.0);
}

}  // namespace

Mask Alike(const ScalarField& image, const Tissue& tissue) {
  Mask same(image.grid, 0);
  for (std::size_t i = 0; i < image.values.size(); ++i)
    same.values[i] = image.values[i] > tissue.low_hu && image.values[i] < tissue.high_hu;
  return same;
}

Tissue LearnTissue(const ScalarField& image, const OrganKnowledge& knowledge,
                   const std::vector<Vec3>& seeds, const std::string& source) {
  std::vector<float> first;
  for (const Vec3& seed : seeds)
    for (const float v : BallValues(image, seed, 6, nullptr)) first.push_back(v);
  Tissue tissue;
  tissue.mean_hu = Median(first);
  if (tissue.mean_hu < knowledge.seed_hu[0] || tissue.mean_hu > knowledge.seed_hu[1])
    throw InputError(
        source, "organ seed",
        fmt::format("lies in tissue of {:.0f} HU; {} parenchyma has {:.0f} to {:.0f}",
                    tissue.mean_hu, knowledge.name, knowledge.seed_hu[0], knowledge.seed_hu[1]));
  // A seed beside fat or a sinus sees them in its first ball: noise is what the tissue alike has.
  double noise = 0;
  for (int round = 0; round < 5; ++round) {
    SetWindow(knowledge, noise, &tissue);
    const Mask same = Alike(image, tissue);
    std::vector<float> wide;
    for (const Vec3& seed : seeds)
      for (const float v : BallValues(image, seed, 25, &same)) wide.push_back(v);
    if (wide.size() < 20) break;
    tissue.mean_hu = Median(wide);
    noise = LocalNoise(image, same, seeds);
  }
  return tissue;
}

bool LearnTissueAgain(const ScalarField& image, const Mask& found, const OrganKnowledge& knowledge,
                      Tissue* tissue) {
  constexpr double kSame_hu = 1;
  std::vector<float> values;
  for (std::size_t i = 0; i < found.values.size(); ++i)
    if (found.values[i]) values.push_back(image.values[i]);
  if (knowledge.follow_drift || values.empty() || Volume_ml(found) > knowledge.volume_ml[1])
    return false;
  const double shift = Median(std::move(values)) - tissue->mean_hu;
  tissue->mean_hu += shift;
  tissue->low_hu += shift;
  tissue->high_hu += shift;
  return std::abs(shift) > kSame_hu;
}

}  // namespace kerf
