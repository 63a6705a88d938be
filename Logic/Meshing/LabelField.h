#pragma once

#include <array>
#include <string>
#include <vector>

#include "Core/Progress.h"
#include "Core/Volume.h"

namespace kerf {

/// Voxels of some labels as a smooth field over space: about 1 inside, 0 outside, and `level` on
/// the boundary. The kernel is 2·G − G∗G (G a Gaussian): its second moment is zero, so that thin
/// tubes and small tumours keep their size, which a Gaussian alone would not grant; `level` is set
/// so that the enclosed volume is that of the voxels.
struct LabelField {
  GridGeometry grid;  ///< the voxels' grid, cropped to the labels and padded with background
  std::vector<float> values;  ///< x fastest
  double level = 0.5;
  double voxel_volume_mm3 = 0.0;  ///< volume of the voxels that went in
  double slope_per_mm = 0.5;      ///< |gradient| across a flat boundary

  bool Empty() const { return values.empty(); }
  /// Trilinear between voxel centres, 0 outside the grid. @param world LPS, mm
  double At(const Vec3& world) const;
  bool Inside(const Vec3& world) const { return At(world) > level; }
};

/// Standard deviation of the kernel along each voxel axis, mm: 1 mm where voxels allow, never finer
/// than the voxels.
Vec3 SmoothingSigma_mm(const GridGeometry& grid);

/// Field of the voxels for which `mask` (labels.grid) is not zero; empty where there is none.
LabelField SmoothMask(const GridGeometry& grid, const std::vector<std::uint8_t>& mask);
/// Field of one label.
LabelField SmoothLabel(const LabelMap& labels, Label label);

/// The organ's voxels: labels 1, 2 and 3 together, cavities filled, the largest 6-connected part.
/// What is filled or dropped is said through `progress`. @return mask over labels.grid, 0/1
/// @throws InputError naming labels.source: no voxel of these labels, voxel array of the wrong size
std::vector<std::uint8_t> OrganMask(const LabelMap& labels, Progress& progress);

/// A deepest voxel centre (world, LPS) of every 6-connected part of the field's inside, largest
/// part first.
std::vector<Vec3> InteriorSeeds(const LabelField& field);

}  // namespace kerf
