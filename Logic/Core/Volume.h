#pragma once

#include <array>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "Core/Types.h"

namespace kerf {

/// Regular grid in patient LPS: world = origin + direction · (spacing ∘ index), index (0,0,0) =
/// centre of first voxel.
struct GridGeometry {
  Eigen::Vector3i size = Eigen::Vector3i::Zero();
  Vec3 spacing_mm = Vec3::Ones();
  Vec3 origin_mm = Vec3::Zero();
  Mat3 direction = Mat3::Identity();  ///< columns are the unit axes i, j, k in LPS

  Vec3 WorldFromIndex(const Vec3& index) const {
    return origin_mm + direction * spacing_mm.cwiseProduct(index);
  }
  Vec3 IndexFromWorld(const Vec3& world) const {
    return (direction.inverse() * (world - origin_mm)).cwiseQuotient(spacing_mm);
  }
  std::size_t VoxelCount() const { return std::size_t(size[0]) * size[1] * size[2]; }
  double VoxelVolume_mm3() const { return spacing_mm.prod() * std::abs(direction.determinant()); }
  std::size_t Offset(int i, int j, int k) const {
    return (std::size_t(k) * size[1] + j) * size[0] + i;
  }
  bool SameAs(const GridGeometry& other, double tolerance_mm = 1e-3) const;
  /// @throws InputError (with `file`) on non-positive size, spacing, NaN, or a direction that is no
  /// rotation/reflection
  void Validate(const std::string& file) const;
};

/// CT, Hounsfield units, x fastest. Voxels are shared and constant: copies are cheap, snapshots
/// safe.
struct Volume {
  GridGeometry grid;
  std::shared_ptr<const std::vector<std::int16_t>> voxels;
  std::string source;                           ///< path, for messages
  std::map<std::string, std::string> metadata;  ///< modality, series UID …; never a patient name
};

/// One label per voxel (Label values; others are kept as they are), x fastest.
struct LabelMap {
  GridGeometry grid;
  std::shared_ptr<const std::vector<std::uint8_t>> voxels;
  std::string source;
  std::map<int, std::string> names;

  /// Volume of one label, mm³.
  double LabelVolume_mm3(Label label) const;
};

}  // namespace kerf
