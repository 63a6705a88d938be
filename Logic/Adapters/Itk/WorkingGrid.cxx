#include "Adapters/Itk/WorkingGrid.h"

#include <cmath>

#include "Adapters/Itk/Parallel.h"

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

/// The index in a target grid is affine in the index here: three steps instead of a matrix for each
/// voxel.
struct Steps {
  Vec3 base, step[3];
  Steps(const GridGeometry& grid, const GridGeometry& target)
      : base(target.IndexFromWorld(grid.WorldFromIndex(Vec3::Zero()))) {
    for (int a = 0; a < 3; ++a)
      step[a] = target.IndexFromWorld(grid.WorldFromIndex(Vec3::Unit(a))) - base;
  }
  /// Each axis runs along the target's.
  bool AxesApart() const {
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b)
        if (a != b && step[a][b] != 0) return false;
    return true;
  }
};

/// f(offset, index in the target), slices side by side.
template <class F>
void ForEachWorld(const GridGeometry& grid, const GridGeometry& target, F&& f) {
  const Steps steps(grid, target);
  itk_bridge::ParallelFor(grid.size[2], [&](int k) {
    std::size_t at = grid.Offset(0, 0, k);
    for (int j = 0; j < grid.size[1]; ++j) {
      const Vec3 row = steps.base + k * steps.step[2] + j * steps.step[1];
      for (int i = 0; i < grid.size[0]; ++i, ++at) f(at, Vec3(row + i * steps.step[0]));
    }
  });
}

/// One sub-sample along an axis: two voxels and the weight of the second.
struct Between {
  int low, high;
  double fraction;
};

/// For every voxel along an axis its sub-samples, one after the other.
std::vector<Between> AlongAxis(const GridGeometry& grid, const GridGeometry& target,
                               const Steps& steps, int axis, int parts) {
  std::vector<Between> between;
  const double ratio = grid.spacing_mm[axis] / target.spacing_mm[axis];
  for (int n = 0; n < grid.size[axis]; ++n)
    for (int p = 0; p < parts; ++p) {
      const double index =
          steps.base[axis] + n * steps.step[axis][axis] + ((p + 0.5) / parts - 0.5) * ratio;
      const double x = std::clamp(index, 0.0, target.size[axis] - 1.0);
      const int low = std::min(static_cast<int>(x), target.size[axis] - 1);
      between.push_back({low, std::min(low + 1, target.size[axis] - 1), x - low});
    }
  return between;
}

/// Means over parts[0] × parts[1] × parts[2] trilinear samples of each voxel of a grid along the
/// axes of the volume's. @param value of a voxel's offset in the volume
template <class Values>
void SampleAlongAxes(const GridGeometry& from, const Values& value, const Steps& steps,
                     const int parts[3], ScalarField* out) {
  const GridGeometry& grid = out->grid;
  std::vector<Between> along[3];
  for (int a = 0; a < 3; ++a) along[a] = AlongAxis(grid, from, steps, a, parts[a]);
  const int total = parts[0] * parts[1] * parts[2];
  itk_bridge::ParallelFor(grid.size[2], [&](int k) {
    std::size_t at = grid.Offset(0, 0, k);
    for (int j = 0; j < grid.size[1]; ++j)
      for (int i = 0; i < grid.size[0]; ++i, ++at) {
        double sum = 0;
        for (int c = 0; c < parts[2]; ++c)
          for (int b = 0; b < parts[1]; ++b) {
            const Between& z = along[2][k * parts[2] + c];
            const Between& y = along[1][j * parts[1] + b];
            const std::size_t rows[4] = {
                from.Offset(0, y.low, z.low), from.Offset(0, y.high, z.low),
                from.Offset(0, y.low, z.high), from.Offset(0, y.high, z.high)};
            for (int a = 0; a < parts[0]; ++a) {
              const Between& x = along[0][i * parts[0] + a];
              double sample = 0;
              for (int r = 0; r < 4; ++r) {
                const double wy = r & 1 ? y.fraction : 1 - y.fraction;
                const double wz = r & 2 ? z.fraction : 1 - z.fraction;
                sample += (1 - x.fraction) * wy * wz * value(rows[r] + x.low);
                sample += x.fraction * wy * wz * value(rows[r] + x.high);
              }
              sum += sample;
            }
          }
        out->values[at] = float(sum / total);
      }
  });
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
  const Steps steps(grid, ct.grid);
  if (steps.AxesApart()) {
    SampleAlongAxes(ct.grid, value, steps, parts, &out);
    return out;
  }
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
