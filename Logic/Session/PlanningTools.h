#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "Core/Progress.h"
#include "Core/Volume.h"

/// Segmentation tools: label map in, voxels of the new label map out (same grid). Nothing is
/// changed in place; all are cancellable (@throws Cancelled) and deterministic.
namespace kerf {

using LabelVoxels = std::vector<std::uint8_t>;

/// Voxels with low ≤ HU ≤ high become `label`. @param within only where this label is now; −1 =
/// everywhere
LabelVoxels ThresholdTool(const Volume& ct, const LabelMap& labels, int label, int low_hu,
                          int high_hu, int within, Progress& progress);

/// What is connected to `seed` (voxel index) by faces and whose HU lies within ± tolerance of the
/// seed's surroundings (mean of 3×3×3). Only background and `label` are taken.
/// @param reach_mm at most this far from the seed
/// @throws InputError naming the seed when it lies outside the volume
LabelVoxels GrowTool(const Volume& ct, const LabelMap& labels, int label,
                     const Eigen::Vector3i& seed, double tolerance_hu, double reach_mm,
                     Progress& progress);

/// Keeps the largest face-connected part of `label` (0 = of all labels together); the rest becomes
/// background.
LabelVoxels KeepLargestTool(const LabelMap& labels, int label, Progress& progress);
/// Parts of `label` below `least_ml` become background.
LabelVoxels RemoveIslandsTool(const LabelMap& labels, int label, double least_ml,
                              Progress& progress);
/// Background enclosed by labels becomes `label`.
LabelVoxels FillHolesTool(const LabelMap& labels, int label, Progress& progress);
/// Majority within about `radius_mm` at the level that keeps the volume: rounds edges, removes
/// spikes. Other labels keep their voxels.
LabelVoxels SmoothTool(const LabelMap& labels, int label, double radius_mm, Progress& progress);

enum class BooleanOperation { Add, Subtract, Intersect };
/// With B = the voxels at most `reach_mm` away from label `other` (labels exclude each other, so
/// that B is more than `other` only by its reach): Add takes over what B holds of background and
/// `other`; Subtract clears what B holds of `label`; Intersect clears what B does not hold of it.
LabelVoxels BooleanTool(const LabelMap& labels, int label, int other, BooleanOperation operation,
                        double reach_mm, Progress& progress);

/// A finished label map on the CT's grid (nearest voxel), values mapped by `role_of` (value →
/// 0…3; missing = 0). @throws InputError naming labels.source when nothing of it lies in the CT
LabelVoxels MapLabels(const LabelMap& labels, const std::map<int, int>& role_of,
                      const GridGeometry& grid, Progress& progress);

/// What a person should look at before meshing.
struct LabelFinding {
  enum class Kind { Holes, Islands, Border, OutsideOrgan, Empty } kind;
  int label = 0;
  std::string sentence;  ///< what is wrong and what to do
};
std::vector<LabelFinding> CheckLabels(const LabelMap& labels, Progress& progress);

/// Voxels that are not of `label` and at most `margin_mm` away from it (exact Euclidean distance
/// between voxel centres), as a mask over labels.grid.
std::vector<std::uint8_t> MarginVoxels(const LabelMap& labels, int label, double margin_mm,
                                       Progress& progress);

}  // namespace kerf
