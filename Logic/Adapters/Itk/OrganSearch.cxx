#include "Adapters/Itk/OrganSearch.h"

#include <fmt/format.h>

#include <cmath>

#include "Adapters/Itk/Parts.h"
#include "Adapters/Itk/Statistics.h"
#include "Adapters/Itk/WorkingGrid.h"
#include "Core/Errors.h"

namespace kerf {
namespace {

constexpr double kSearchSpacing_mm = 2.5;

struct Body {
  std::size_t voxels = 0, at_border = 0, deepest = 0;
  float depth_mm = 0;
  double sum_hu = 0;
};

bool AtBorder(const GridGeometry& grid, std::size_t at) {
  const auto& s = grid.size;
  const int x = int(at % s[0]), y = int(at / s[0] % s[1]), z = int(at / (std::size_t(s[0]) * s[1]));
  return x == 0 || y == 0 || z == 0 || x == s[0] - 1 || y == s[1] - 1 || z == s[2] - 1;
}

std::vector<Body> BodiesOf(const ScalarField& image, const Mask& mask) {
  const ScalarField depth = SignedDistance_mm(mask);
  const auto part = DivideAtNecks(depth, 0.7, 0.5);
  std::vector<Body> bodies(
      std::size_t(1 + *std::max_element(part.values.begin(), part.values.end())));
  for (std::size_t i = 0; i < part.values.size(); ++i) {
    if (part.values[i] < 0) continue;
    Body& body = bodies[std::size_t(part.values[i])];
    ++body.voxels;
    body.sum_hu += image.values[i];
    if (AtBorder(image.grid, i)) ++body.at_border;
    if (depth.values[i] > body.depth_mm) {
      body.depth_mm = depth.values[i];
      body.deepest = i;
    }
  }
  return bodies;
}

Vec3 WorldOf(const GridGeometry& grid, std::size_t at) {
  const auto& s = grid.size;
  return grid.WorldFromIndex(
      Vec3(double(at % s[0]), double(at / s[0] % s[1]), double(at / (std::size_t(s[0]) * s[1]))));
}

ScalarField Overview(const Volume& ct, Progress& progress) {
  const auto& g = ct.grid;
  const Vec3 middle = g.WorldFromIndex((g.size.cast<double>() - Vec3::Ones()) / 2);
  const double reach = (g.size.cast<double>().cwiseProduct(g.spacing_mm)).maxCoeff();
  double spacing = kSearchSpacing_mm;
  const double volume = g.size.cast<double>().cwiseProduct(g.spacing_mm).prod();
  spacing = std::max(spacing, std::cbrt(volume / 8e6));
  const GridGeometry grid = WorkingGrid(g, middle, reach, spacing);
  return Denoise(Sample(ct, grid, progress), 10, progress);
}

}  // namespace

FoundOrgan FindStudyOrgan(const Volume& ct, Progress& progress) {
  const ScalarField image = Overview(ct, progress);
  const double voxel_ml = image.grid.VoxelVolume_mm3() / 1000;
  double best_score = 0;
  FoundOrgan best;
  // From above every soft tissue down to above all but contrast agent: the organ stands free at
  // some level.
  for (const double level : {10., 30., 50., 70., 90., 110., 130., 150.}) {
    progress.ThrowIfCancelled();
    Mask mask = FillHoles(AtLeast(image, float(level)));
    for (const Body& body : BodiesOf(image, mask)) {
      const double ml = double(body.voxels) * voxel_ml;
      const double border = double(body.at_border) / std::max<double>(1, double(body.voxels));
      if (ml < 15 || body.depth_mm < 8 || border > 0.01) continue;
      const double mean = body.sum_hu / double(body.voxels);
      // Thick and bright: neighbours of the same thickness are darker, brighter ones (bone,
      // contrast) thinner.
      const double score = body.depth_mm * (std::min(mean, 220.0) + 60);
      if (score <= best_score) continue;
      best_score = score;
      best.seed_mm = WorldOf(image.grid, body.deepest);
      best.mean_hu = mean;
    }
  }
  if (best_score == 0)
    throw InputError(ct.source, "voxels",
                     "no organ stands out in the CT; give a preset and a seed");
  // Nephrographic parenchyma is brighter than the liver in any phase, calyces filled with contrast
  // are brighter still.
  std::size_t filled = 0;
  for (std::size_t i = 0; i < image.values.size(); ++i)
    if (image.values[i] > 350 && (WorldOf(image.grid, i) - best.seed_mm).norm() < 60) ++filled;
  best.preset = best.mean_hu > 135 || double(filled) * voxel_ml > 0.3 ? OrganPreset::Kidney
                                                                      : OrganPreset::Liver;
  return best;
}

Vec3 FindLiverSeed(const Volume& ct, const OrganKnowledge& liver, Progress& progress) {
  const ScalarField image = Overview(ct, progress);
  Mask mask(image.grid, 0);
  for (std::size_t i = 0; i < mask.values.size(); ++i)
    mask.values[i] = image.values[i] > std::max(liver.seed_hu[0], 20.0) &&
                     image.values[i] < std::min(liver.seed_hu[1], 160.0);
  mask = Open(Close(mask, 3), 3);
  const Vec3 middle = image.grid.WorldFromIndex(image.grid.size.cast<double>() / 2);
  double best_score = 0;
  Vec3 seed = Vec3::Zero();
  for (const Body& body : BodiesOf(image, mask)) {
    const Vec3 at = WorldOf(image.grid, body.deepest);
    const double right = at[0] < middle[0] ? 1.0 : 0.6;
    const double score = body.depth_mm * right;
    if (body.depth_mm < 20 || score <= best_score) continue;
    best_score = score;
    seed = at;
  }
  if (best_score == 0)
    throw InputError(ct.source, "voxels", "no liver found without a seed; give an organ seed");
  return seed;
}

}  // namespace kerf
