#include "Meshing/LabelField.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>
#include <numeric>

namespace kerf {
namespace {

/// 6-connected parts of the voxels that `wanted` accepts: part number per voxel (−1 elsewhere) and
/// voxel counts.
std::vector<std::size_t> ConnectedParts(const Eigen::Vector3i& size,
                                        const std::function<bool(std::size_t)>& wanted,
                                        std::vector<int>* part_of_voxel) {
  const std::array<std::ptrdiff_t, 3> stride{1, size[0], std::ptrdiff_t(size[0]) * size[1]};
  const std::size_t count = std::size_t(size[0]) * size[1] * size[2];
  part_of_voxel->assign(count, -1);
  std::vector<std::size_t> sizes, stack;
  for (std::size_t seed = 0; seed < count; ++seed) {
    if ((*part_of_voxel)[seed] >= 0 || !wanted(seed)) continue;
    const int part = static_cast<int>(sizes.size());
    sizes.push_back(0);
    (*part_of_voxel)[seed] = part;
    stack.push_back(seed);
    while (!stack.empty()) {
      const std::size_t v = stack.back();
      stack.pop_back();
      ++sizes[part];
      const std::array<int, 3> at{int(v % size[0]), int(v / size[0] % size[1]), int(v / stride[2])};
      for (int d = 0; d < 3; ++d)
        for (int step : {-1, 1}) {
          if (at[d] + step < 0 || at[d] + step >= size[d]) continue;
          const std::size_t n = v + step * stride[d];
          if ((*part_of_voxel)[n] >= 0 || !wanted(n)) continue;
          (*part_of_voxel)[n] = part;
          stack.push_back(n);
        }
    }
  }
  return sizes;
}

std::vector<float> GaussianKernel(double sigma_voxels) {
  const int radius = std::max(1, static_cast<int>(std::ceil(3.5 * sigma_voxels)));
  std::vector<float> kernel(2 * radius + 1);
  double sum = 0.0;
  for (int i = -radius; i <= radius; ++i)
    sum += kernel[i + radius] =
        static_cast<float>(std::exp(-0.5 * i * i / (sigma_voxels * sigma_voxels)));
  for (float& k : kernel) k /= static_cast<float>(sum);
  return kernel;
}

/// One pass along one axis; outside the grid counts as background.
void Convolve(const Eigen::Vector3i& size, int axis, const std::vector<float>& kernel,
              std::vector<float>* values) {
  const std::ptrdiff_t stride = axis == 0   ? 1
                                : axis == 1 ? size[0]
                                            : std::ptrdiff_t(size[0]) * size[1];
  const int n = size[axis], radius = static_cast<int>(kernel.size() / 2);
  const int a = axis == 0 ? 1 : 0, b = axis == 2 ? 1 : 2;
  const std::ptrdiff_t stride_a = a == 0 ? 1 : size[0];
  const std::ptrdiff_t stride_b = b == 1 ? size[0] : std::ptrdiff_t(size[0]) * size[1];
  std::vector<float> line(n + 2 * radius, 0.0F);
  for (int j = 0; j < size[b]; ++j)
    for (int i = 0; i < size[a]; ++i) {
      float* base = values->data() + i * stride_a + j * stride_b;
      for (int x = 0; x < n; ++x) line[x + radius] = base[x * stride];
      for (int x = 0; x < n; ++x) {
        float sum = 0.0F;
        for (std::size_t k = 0; k < kernel.size(); ++k) sum += kernel[k] * line[x + k];
        base[x * stride] = sum;
      }
    }
}

void GaussianSmooth(const GridGeometry& grid, const Vec3& sigma_mm, std::vector<float>* values) {
  for (int d = 0; d < 3; ++d)
    Convolve(grid.size, d, GaussianKernel(sigma_mm[d] / grid.spacing_mm[d]), values);
}

std::string Millilitres(double mm3) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2f mL", mm3 / 1000.0);
  return text;
}

}  // namespace

double LabelField::At(const Vec3& world) const {
  const Vec3 index = grid.IndexFromWorld(world);
  std::array<int, 3> low;
  Vec3 t;
  for (int d = 0; d < 3; ++d) {
    const double f = std::floor(index[d]);
    if (!(f >= 0.0) || f + 1.0 >= grid.size[d]) return 0.0;
    low[d] = static_cast<int>(f);
    t[d] = index[d] - f;
  }
  const std::size_t row = grid.size[0], slice = row * grid.size[1];
  const float* v = values.data() + grid.Offset(low[0], low[1], low[2]);
  const auto lerp = [](double a, double b, double s) { return a + (b - a) * s; };
  return lerp(lerp(lerp(v[0], v[1], t[0]), lerp(v[row], v[row + 1], t[0]), t[1]),
              lerp(lerp(v[slice], v[slice + 1], t[0]),
                   lerp(v[slice + row], v[slice + row + 1], t[0]), t[1]),
              t[2]);
}

Vec3 SmoothingSigma_mm(const GridGeometry& grid) {
  const double base = std::min(1.0, 1.2 * grid.spacing_mm.maxCoeff());
  return (0.8 * grid.spacing_mm).cwiseMax(base);
}

LabelField SmoothMask(const GridGeometry& grid, const std::vector<std::uint8_t>& mask) {
  Eigen::Vector3i low = grid.size, high = Eigen::Vector3i::Constant(-1);
  std::size_t count = 0;
  for (int k = 0; k < grid.size[2]; ++k)
    for (int j = 0; j < grid.size[1]; ++j)
      for (int i = 0; i < grid.size[0]; ++i) {
        if (!mask[grid.Offset(i, j, k)]) continue;
        ++count;
        low = low.cwiseMin(Eigen::Vector3i(i, j, k));
        high = high.cwiseMax(Eigen::Vector3i(i, j, k));
      }
  LabelField field;
  if (count == 0) return field;
  const Vec3 sigma_mm = SmoothingSigma_mm(grid);
  // Room for the kernel's tails, so that the field ends in zeros even where the labels touch the
  // volume's border.
  Eigen::Vector3i pad;
  for (int d = 0; d < 3; ++d)
    pad[d] = 2 + static_cast<int>(std::ceil(3.0 * sigma_mm[d] / grid.spacing_mm[d]));
  field.grid = grid;
  field.grid.size = high - low + Eigen::Vector3i::Ones() + 2 * pad;
  field.grid.origin_mm = grid.WorldFromIndex((low - pad).cast<double>());
  field.values.assign(field.grid.VoxelCount(), 0.0F);
  for (int k = low[2]; k <= high[2]; ++k)
    for (int j = low[1]; j <= high[1]; ++j)
      for (int i = low[0]; i <= high[0]; ++i)
        if (mask[grid.Offset(i, j, k)])
          field.values[field.grid.Offset(i - low[0] + pad[0], j - low[1] + pad[1],
                                         k - low[2] + pad[2])] = 1.0F;
  GaussianSmooth(field.grid, sigma_mm, &field.values);
  std::vector<float> twice = field.values;
  GaussianSmooth(field.grid, sigma_mm, &twice);
  for (std::size_t i = 0; i < twice.size(); ++i)
    field.values[i] = 2.0F * field.values[i] - twice[i];
  // The level that encloses as many voxel centres as there are voxels, kept near 1/2: far from it
  // the boundary would leave the zone where the field falls.
  std::vector<float> sorted = field.values;
  std::nth_element(sorted.begin(), sorted.begin() + (count - 1), sorted.end(), std::greater<>());
  field.level = std::clamp(static_cast<double>(sorted[count - 1]), 0.35, 0.6);
  field.voxel_volume_mm3 = static_cast<double>(count) * grid.VoxelVolume_mm3();
  // d/dx (2Φ(x/σ) − Φ(x/√2σ)) at 0.
  field.slope_per_mm = (2.0 - std::sqrt(0.5)) / std::sqrt(2.0 * M_PI) / sigma_mm.mean();
  return field;
}

LabelField SmoothLabel(const LabelMap& labels, Label label) {
  std::vector<std::uint8_t> mask(labels.voxels->size());
  for (std::size_t i = 0; i < mask.size(); ++i)
    mask[i] = (*labels.voxels)[i] == static_cast<std::uint8_t>(label);
  return SmoothMask(labels.grid, mask);
}

std::vector<std::uint8_t> OrganMask(const LabelMap& labels, Progress& progress) {
  labels.grid.Validate(labels.source);
  if (!labels.voxels || labels.voxels->size() != labels.grid.VoxelCount())
    throw InputError(labels.source, "voxels", "their number does not fit the size");
  const auto& voxels = *labels.voxels;
  const double voxel_mm3 = labels.grid.VoxelVolume_mm3();
  std::vector<int> part;
  const auto sizes = ConnectedParts(
      labels.grid.size, [&](std::size_t v) { return voxels[v] >= 1 && voxels[v] <= 3; }, &part);
  if (sizes.empty())
    throw InputError(labels.source, "labels",
                     "no voxel is labelled 1 (organ), 2 (tumour) or 3 (inner structure)");
  const int largest =
      static_cast<int>(std::max_element(sizes.begin(), sizes.end()) - sizes.begin());
  std::vector<std::uint8_t> mask(voxels.size());
  for (std::size_t v = 0; v < mask.size(); ++v) mask[v] = part[v] == largest;
  const std::size_t dropped =
      std::accumulate(sizes.begin(), sizes.end(), std::size_t(0)) - sizes[largest];
  if (dropped > 0)
    progress.Warn(labels.source + ": " + std::to_string(sizes.size() - 1) +
                  " part(s) apart from the organ are left out (" +
                  Millilitres(dropped * voxel_mm3) + ")");
  // Cavities: background that does not reach the volume's border.
  const auto holes = ConnectedParts(
      labels.grid.size, [&](std::size_t v) { return !mask[v]; }, &part);
  std::vector<char> open(holes.size(), 0);
  const auto& size = labels.grid.size;
  for (int k = 0; k < size[2]; ++k)
    for (int j = 0; j < size[1]; ++j)
      for (int i = 0; i < size[0]; ++i) {
        const bool border =
            i == 0 || j == 0 || k == 0 || i + 1 == size[0] || j + 1 == size[1] || k + 1 == size[2];
        const int p = part[labels.grid.Offset(i, j, k)];
        if (border && p >= 0) open[p] = 1;
      }
  std::size_t filled = 0;
  for (std::size_t v = 0; v < mask.size(); ++v)
    if (part[v] >= 0 && !open[part[v]]) {
      mask[v] = 1;
      ++filled;
    }
  if (filled > 0)
    progress.Warn(labels.source + ": cavities of the organ are filled (" +
                  Millilitres(filled * voxel_mm3) + ")");
  return mask;
}

std::vector<Vec3> InteriorSeeds(const LabelField& field) {
  std::vector<int> part;
  const auto sizes = ConnectedParts(
      field.grid.size, [&](std::size_t v) { return field.values[v] > field.level; }, &part);
  std::vector<std::size_t> deepest(sizes.size(), std::numeric_limits<std::size_t>::max());
  for (std::size_t v = 0; v < part.size(); ++v) {
    if (part[v] < 0) continue;
    std::size_t& best = deepest[part[v]];
    if (best == std::numeric_limits<std::size_t>::max() || field.values[v] > field.values[best])
      best = v;
  }
  std::vector<int> order(sizes.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return sizes[a] > sizes[b]; });
  std::vector<Vec3> seeds;
  for (int p : order) {
    const std::size_t v = deepest[p], row = field.grid.size[0], slice = row * field.grid.size[1];
    seeds.push_back(field.grid.WorldFromIndex(
        Vec3(double(v % row), double(v / row % field.grid.size[1]), double(v / slice))));
  }
  return seeds;
}

}  // namespace kerf
