#include "Adapters/Itk/RandomWalker.h"

#include <array>
#include <cmath>

namespace kerf {
namespace {

constexpr double kLeastWeight = 1e-6;  // keeps every voxel connected

/// Rows of the Laplacian over the undecided voxels: at most six neighbours each.
struct Row {
  std::array<std::int32_t, 6> neighbor;  // unknown, or −1
  std::array<float, 6> weight;
  double diagonal = 0, right_hand_side = 0;
};

}  // namespace

ScalarField RandomWalk(const ScalarField& image, const Mask& markers,
                       const RandomWalkerOptions& options, Progress& progress) {
  const auto& size = image.grid.size;
  const std::ptrdiff_t stride[3] = {1, size[0], std::ptrdiff_t(size[0]) * size[1]};
  std::vector<std::int32_t> unknown_of(image.values.size(), -1);
  std::vector<std::size_t> voxel_of;
  for (std::size_t i = 0; i < markers.values.size(); ++i)
    if (markers.values[i] == 0) {
      unknown_of[i] = static_cast<std::int32_t>(voxel_of.size());
      voxel_of.push_back(i);
    }
  ScalarField out(image.grid, 0.f);
  for (std::size_t i = 0; i < markers.values.size(); ++i) out.values[i] = markers.values[i] == 2;
  const std::size_t n = voxel_of.size();
  if (n == 0) return out;

  const double smallest = image.grid.spacing_mm.minCoeff();
  std::vector<Row> rows(n);
  for (std::size_t u = 0; u < n; ++u) {
    const std::size_t at = voxel_of[u];
    const int index[3] = {int(at % size[0]), int(at / size[0] % size[1]),
                          int(at / (std::size_t(size[0]) * size[1]))};
    Row& row = rows[u];
    int slot = 0;
    for (int axis = 0; axis < 3; ++axis)
      for (const int step : {-1, 1}) {
        row.neighbor[slot] = -1;
        row.weight[slot] = 0;
        const int next = index[axis] + step;
        if (next >= 0 && next < size[axis]) {
          const std::size_t to = std::size_t(std::ptrdiff_t(at) + step * stride[axis]);
          const double difference = (image.values[to] - image.values[at]) / options.sigma_hu;
          const double ratio = smallest / image.grid.spacing_mm[axis];
          const double w = (std::exp(-difference * difference) + kLeastWeight) * ratio * ratio;
          row.diagonal += w;
          row.weight[slot] = float(w);
          row.neighbor[slot] = unknown_of[to];
          if (markers.values[to] == 2) row.right_hand_side += w;
        }
        ++slot;
      }
  }

  const auto multiply = [&](const std::vector<double>& x, std::vector<double>& y) {
    for (std::size_t u = 0; u < n; ++u) {
      const Row& row = rows[u];
      double sum = row.diagonal * x[u];
      for (int s = 0; s < 6; ++s)
        if (row.neighbor[s] >= 0) sum -= double(row.weight[s]) * x[row.neighbor[s]];
      y[u] = sum;
    }
  };
  std::vector<double> x(n, 0.0), r(n), z(n), p(n), q(n);
  double rz = 0, norm0 = 0;
  for (std::size_t u = 0; u < n; ++u) {
    r[u] = rows[u].right_hand_side;
    z[u] = r[u] / rows[u].diagonal;
    rz += r[u] * z[u];
  }
  norm0 = rz;
  p = z;
  for (int iteration = 0; iteration < options.max_iterations && norm0 > 0; ++iteration) {
    if (iteration % 10 == 0) {
      progress.ThrowIfCancelled();
      progress.Report(double(iteration) / options.max_iterations, "walking");
    }
    multiply(p, q);
    double pq = 0;
    for (std::size_t u = 0; u < n; ++u) pq += p[u] * q[u];
    if (!(pq > 0)) break;
    const double alpha = rz / pq;
    double next = 0;
    for (std::size_t u = 0; u < n; ++u) {
      x[u] += alpha * p[u];
      r[u] -= alpha * q[u];
      z[u] = r[u] / rows[u].diagonal;
      next += r[u] * z[u];
    }
    if (next <= options.tolerance * options.tolerance * norm0) break;
    const double beta = next / rz;
    for (std::size_t u = 0; u < n; ++u) p[u] = z[u] + beta * p[u];
    rz = next;
  }
  for (std::size_t u = 0; u < n; ++u) out.values[voxel_of[u]] = float(x[u]);
  return out;
}

}  // namespace kerf
