#include "Adapters/Itk/WorkingGrid.h"

#include <cmath>

namespace kerf {
namespace {

/// Corner and weights of trilinear interpolation; false outside the grid by more than half a voxel.
struct Corner {
  Eigen::Vector3i low, high;
  Vec3 fraction;
  bool inside = true;
};

Corner CornerAt(const GridGeometry& grid, const Vec3& index) {
  Corner c;
  for (int a = 0; a < 3; ++a) {
    c.inside = c.inside && index[a] >= -0.5 && index[a] <= grid.size[a] - 0.5;
    const double x = std::clamp(index[a], 0.0, grid.size[a] - 1.0);
    c.low[a] = std::min(static_cast<int>(x), grid.size[a] - 1);
    c.high[a] = std::min(c.low[a] + 1, grid.size[a] - 1);
    c.fraction[a] = x - c.low[a];
  }
  return c;
}

template <class Values>
double Interpolate(const GridGeometry& grid, const Values& values, const Corner& c) {
  double sum = 0;
  for (int n = 0; n < 8; ++n) {
    double weight = 1;
    Eigen::Vector3i at;
    for (int a = 0; a < 3; ++a) {
      const bool up = (n >> a) & 1;
      at[a] = up ? c.high[a] : c.low[a];
      weight *= up ? c.fraction[a] : 1 - c.fraction[a];
    }
    if (weight > 0) sum += weight * values(grid.Offset(at[0], at[1], at[2]));
  }
  return sum;
}

template <class F>
void ForEachWorld(const GridGeometry& grid, const GridGeometry& target, F&& f) {
  // index in the target is affine in the index here: three steps instead of a matrix for each
  // voxel.
  const Vec3 base = target.IndexFromWorld(grid.WorldFromIndex(Vec3::Zero()));
  Vec3 step[3];
  for (int a = 0; a < 3; ++a)
    step[a] = target.IndexFromWorld(grid.WorldFromIndex(Vec3::Unit(a))) - base;
  std::size_t at = 0;
  for (int k = 0; k < grid.size[2]; ++k)
    for (int j = 0; j < grid.size[1]; ++j) {
      const Vec3 row = base + k * step[2] + j * step[1];
      for (int i = 0; i < grid.size[0]; ++i, ++at) f(at, Vec3(row + i * step[0]));
    }
}

}  // namespace

GridGeometry WorkingGrid(const GridGeometry& ct, const Vec3& center_mm, double reach_mm,
                         double spacing_mm) {
  const Vec3 center = ct.IndexFromWorld(center_mm);
  GridGeometry grid;
  grid.direction = ct.direction;
  grid.spacing_mm = Vec3::Constant(spacing_mm);
  Vec3 low;
  for (int a = 0; a < 3; ++a) {
    const double reach = reach_mm / ct.spacing_mm[a];
    low[a] = std::max(0.0, center[a] - reach);
    const double high = std::min(ct.size[a] - 1.0, center[a] + reach);
    grid.size[a] = std::max(2, int((high - low[a]) * ct.spacing_mm[a] / spacing_mm + 0.5) + 1);
  }
  grid.origin_mm = ct.WorldFromIndex(low);
  return grid;
}

GridGeometry CropGrid(const GridGeometry& ct, const Eigen::Vector3i& low,
                      const Eigen::Vector3i& high) {
  GridGeometry grid = ct;
  const Eigen::Vector3i first = low.cwiseMax(0);
  const Eigen::Vector3i last = high.cwiseMin(ct.size - Eigen::Vector3i::Ones());
  grid.size = last - first + Eigen::Vector3i::Ones();
  grid.origin_mm = ct.WorldFromIndex(first.cast<double>());
  return grid;
}

ScalarField Sample(const Volume& ct, const GridGeometry& grid, Progress& progress, float most_hu) {
  progress.ThrowIfCancelled();
  ScalarField out(grid, 0.f);
  const auto& voxels = *ct.voxels;
  const auto value = [&](std::size_t at) {
    return std::clamp(double(voxels[at]), double(kLeastHu), double(most_hu));
  };
  // Where the grid is coarser, a few sub-samples along each axis make the voxel's mean.
  int parts[3];
  for (int a = 0; a < 3; ++a)
    parts[a] = std::clamp(int(std::lround(grid.spacing_mm[a] / ct.grid.spacing_mm[a])), 1, 4);
  const bool same_axes = (grid.direction - ct.grid.direction).cwiseAbs().maxCoeff() < 1e-9;
  if (!same_axes) parts[0] = parts[1] = parts[2] = 1;
  const int total = parts[0] * parts[1] * parts[2];
  ForEachWorld(grid, ct.grid, [&](std::size_t at, const Vec3& index) {
    double sum = 0;
    for (int c = 0; c < parts[2]; ++c)
      for (int b = 0; b < parts[1]; ++b)
        for (int a = 0; a < parts[0]; ++a) {
          Vec3 offset((a + 0.5) / parts[0] - 0.5, (b + 0.5) / parts[1] - 0.5,
                      (c + 0.5) / parts[2] - 0.5);
          offset = offset.cwiseProduct(grid.spacing_mm.cwiseQuotient(ct.grid.spacing_mm));
          sum += Interpolate(ct.grid, value, CornerAt(ct.grid, index + offset));
        }
    out.values[at] = float(sum / total);
  });
  return out;
}

ScalarField Resample(const ScalarField& field, const GridGeometry& grid, float outside) {
  ScalarField out(grid, outside);
  const auto value = [&](std::size_t at) { return double(field.values[at]); };
  ForEachWorld(grid, field.grid, [&](std::size_t at, const Vec3& index) {
    const Corner corner = CornerAt(field.grid, index);
    if (corner.inside) out.values[at] = float(Interpolate(field.grid, value, corner));
  });
  return out;
}

void Paste(const Mask& crop, const GridGeometry& ct, std::uint8_t value,
           std::vector<std::uint8_t>* voxels) {
  const Vec3 first = ct.IndexFromWorld(crop.grid.origin_mm);
  const int i0 = int(std::lround(first[0])), j0 = int(std::lround(first[1])),
            k0 = int(std::lround(first[2]));
  std::size_t at = 0;
  for (int k = 0; k < crop.grid.size[2]; ++k)
    for (int j = 0; j < crop.grid.size[1]; ++j)
      for (int i = 0; i < crop.grid.size[0]; ++i, ++at)
        if (crop.values[at]) (*voxels)[ct.Offset(i0 + i, j0 + j, k0 + k)] = value;
}

Eigen::Vector3i NearestIndex(const GridGeometry& grid, const Vec3& point_mm) {
  const Vec3 index = grid.IndexFromWorld(point_mm);
  Eigen::Vector3i out;
  for (int a = 0; a < 3; ++a) out[a] = std::clamp(int(std::lround(index[a])), 0, grid.size[a] - 1);
  return out;
}

bool BoundingBox(const Mask& mask, double margin_mm, Eigen::Vector3i* low, Eigen::Vector3i* high) {
  *low = mask.grid.size;
  *high = Eigen::Vector3i::Constant(-1);
  std::size_t at = 0;
  for (int k = 0; k < mask.grid.size[2]; ++k)
    for (int j = 0; j < mask.grid.size[1]; ++j)
      for (int i = 0; i < mask.grid.size[0]; ++i, ++at)
        if (mask.values[at]) {
          *low = low->cwiseMin(Eigen::Vector3i(i, j, k));
          *high = high->cwiseMax(Eigen::Vector3i(i, j, k));
        }
  if ((*high)[0] < 0) return false;
  for (int a = 0; a < 3; ++a) {
    const int margin = int(std::ceil(margin_mm / mask.grid.spacing_mm[a]));
    (*low)[a] = std::max(0, (*low)[a] - margin);
    (*high)[a] = std::min(mask.grid.size[a] - 1, (*high)[a] + margin);
  }
  return true;
}

}  // namespace kerf
