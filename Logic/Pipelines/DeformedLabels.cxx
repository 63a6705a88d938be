#include "Pipelines/DeformedLabels.h"

#include <algorithm>
#include <cmath>

#include "Core/Embedding.h"

namespace kerf {
namespace {

constexpr double kSpacing_mm = 1.0;
constexpr int kMargin = 2;  // voxels of background around the organ

/// The planned grid, extended by whole voxels until it holds all points.
GridGeometry GridAround(const Points& points, const std::optional<LabelMap>& planned) {
  GridGeometry grid;
  Eigen::Vector3i low = Eigen::Vector3i::Zero(), high = Eigen::Vector3i::Zero();
  if (planned) {
    grid = planned->grid;
    high = grid.size - Eigen::Vector3i::Ones();
  } else {
    grid.spacing_mm = Vec3::Constant(kSpacing_mm);
    grid.origin_mm = points.row(0).transpose();
  }
  for (Index i = 0; i < points.rows(); ++i) {
    const Vec3 index = grid.IndexFromWorld(points.row(i).transpose());
    for (int k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], static_cast<int>(std::floor(index[k])) - kMargin);
      high[k] = std::max(high[k], static_cast<int>(std::ceil(index[k])) + kMargin);
    }
  }
  grid.origin_mm = grid.WorldFromIndex(low.cast<double>());
  grid.size = high - low + Eigen::Vector3i::Ones();
  return grid;
}

std::uint8_t LabelAt(const LabelMap& labels, const Vec3& world) {
  const Vec3 index = labels.grid.IndexFromWorld(world);
  int v[3];
  for (int k = 0; k < 3; ++k) {
    v[k] = static_cast<int>(std::lround(index[k]));
    if (v[k] < 0 || v[k] >= labels.grid.size[k]) return 0;
  }
  const std::uint8_t label = (*labels.voxels)[labels.grid.Offset(v[0], v[1], v[2])];
  return label <= static_cast<std::uint8_t>(Label::Internal) ? label : 0;
}

}  // namespace

LabelMap DeformedLabels(const TetMesh& mesh, const Points& positions,
                        const std::optional<LabelMap>& planned, Progress& progress) {
  LabelMap labels;
  labels.grid = GridAround(positions, planned);
  labels.names = {{1, "organ"}, {2, "tumour"}, {3, "internal"}};
  auto voxels = std::make_shared<std::vector<std::uint8_t>>(labels.grid.VoxelCount(), 0);
  for (Index t = 0; t < mesh.TetCount(); ++t) {
    if (t % 4096 == 0) {
      progress.ThrowIfCancelled();
      progress.Report(double(t) / mesh.TetCount(), "label map as deformed");
    }
    Vec3 corner[4], rest[4], low = Vec3::Constant(1e300), high = -low;
    for (int k = 0; k < 4; ++k) {
      corner[k] = labels.grid.IndexFromWorld(positions.row(mesh.tets(t, k)).transpose());
      rest[k] = mesh.rest.row(mesh.tets(t, k)).transpose();
      low = low.cwiseMin(corner[k]);
      high = high.cwiseMax(corner[k]);
    }
    for (int z = std::ceil(low[2]); z <= std::floor(high[2]); ++z)
      for (int y = std::ceil(low[1]); y <= std::floor(high[1]); ++y)
        for (int x = std::ceil(low[0]); x <= std::floor(high[0]); ++x) {
          const Vec4 w =
              BarycentricWeights(Vec3(x, y, z), corner[0], corner[1], corner[2], corner[3]);
          // A voxel on a shared face belongs to the first of the two.
          if (w.minCoeff() < -1e-9) continue;
          std::uint8_t& voxel = (*voxels)[labels.grid.Offset(x, y, z)];
          if (voxel != 0) continue;
          if (planned) {
            Vec3 at = Vec3::Zero();
            for (int k = 0; k < 4; ++k) at += w[k] * rest[k];
            voxel = LabelAt(*planned, at);
          }
          if (voxel == 0) voxel = mesh.region[t];
        }
  }
  labels.voxels = std::move(voxels);
  return labels;
}

}  // namespace kerf
