#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "Core/Progress.h"
#include "Core/Volume.h"

/// Scalar fields on a grid and the ITK filters that the segmentation is composed of. Private to
/// this component.
namespace kerf {

template <class T>
struct Field {
  GridGeometry grid;
  std::vector<T> values;

  Field() = default;
  Field(const GridGeometry& g, T value) : grid(g), values(g.VoxelCount(), value) {}
};
using Mask = Field<std::uint8_t>;
using ScalarField = Field<float>;

/// Voxels that are set.
std::size_t Count(const Mask& mask);
double Volume_ml(const Mask& mask);

/// Curvature anisotropic diffusion: smooths tissue, keeps edges. Conductance in units of the mean
/// gradient.
ScalarField Denoise(const ScalarField& image, int iterations, Progress& progress);

/// Distance to the mask's boundary, mm: positive inside, negative outside. An empty or full mask
/// gives ∓1e6.
ScalarField SignedDistance_mm(const Mask& mask);

/// Mask of values ≥ threshold.
Mask AtLeast(const ScalarField& field, float threshold);

/// Erosion, dilation, opening and closing by balls of radius_mm, anisotropic spacing respected.
Mask Erode(const Mask& mask, double radius_mm);
Mask Dilate(const Mask& mask, double radius_mm);
Mask Open(const Mask& mask, double radius_mm);
Mask Close(const Mask& mask, double radius_mm);

/// Face-connected components, 1 = largest; sizes[n-1] in voxels.
Field<std::int32_t> Components(const Mask& mask, std::vector<std::size_t>* sizes);
Mask LargestComponent(const Mask& mask);

/// Background components that do not reach the grid's border become set. @param filled number of
/// such components
Mask FillHoles(const Mask& mask, int* filled = nullptr);

/// Voxels of `within` reached from `from` by face steps of at most `reach_mm` in all.
Mask GeodesicGrow(const Mask& from, const Mask& within, double reach_mm);

}  // namespace kerf
