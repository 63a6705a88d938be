#pragma once

#include "Adapters/Itk/Field.h"

namespace kerf {

/// Values that tell nothing about soft tissue are clamped, so that metal and air do not rule
/// gradients and means.
constexpr float kLeastHu = -250, kMostHu = 500;

/// Isotropic grid along the CT's axes around a point, cut off at the CT's border.
GridGeometry WorkingGrid(const GridGeometry& ct, const Vec3& center_mm, double reach_mm,
                         double spacing_mm);

/// The CT's own voxels in an index box [low, high], both included and cut off at the border.
GridGeometry CropGrid(const GridGeometry& ct, const Eigen::Vector3i& low,
                      const Eigen::Vector3i& high);

/// Trilinear samples of the CT (border values outside), clamped to [kLeastHu, most_hu]; averaged
/// over the voxel where the grid is coarser than the CT.
ScalarField Sample(const Volume& ct, const GridGeometry& grid, Progress& progress,
                   float most_hu = kMostHu);

/// Trilinear samples of a field; `outside` where the grid reaches beyond it.
ScalarField Resample(const ScalarField& field, const GridGeometry& grid, float outside);

/// Writes a mask on a crop of `ct` (CropGrid) into a mask of the CT's size.
void Paste(const Mask& crop, const GridGeometry& ct, std::uint8_t value,
           std::vector<std::uint8_t>* voxels);

/// Voxel nearest to a point, LPS mm; at the border where the point lies outside.
Eigen::Vector3i NearestIndex(const GridGeometry& grid, const Vec3& point_mm);

/// Index box of the set voxels, grown by margin_mm. False when none is set.
bool BoundingBox(const Mask& mask, double margin_mm, Eigen::Vector3i* low, Eigen::Vector3i* high);

}  // namespace kerf
