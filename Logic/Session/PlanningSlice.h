#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "Core/Volume.h"

namespace kerf {

enum class SlicePlane { Axial, Coronal, Sagittal };

/// How slices of a grid lie on a screen: along the grid's own axes, each named after the anatomical
/// direction that it is nearest to, in the radiologist's way (patient's right on the left, anterior
/// up or left).
struct SliceFrame {
  SlicePlane plane = SlicePlane::Axial;
  int u_axis = 0, v_axis = 1, n_axis = 2;  ///< grid axes to the right, downwards, through
  bool flip_u = false, flip_v = false;     ///< the axis runs against the screen
  int columns = 0, rows = 0, slices = 0;
  double spacing_u_mm = 1, spacing_v_mm = 1, spacing_n_mm = 1;
  std::string left, right, top, bottom;  ///< R L A P S I

  /// Voxel index of a pixel (column right, row down; fractions allowed) of one slice.
  Vec3 IndexOf(double column, double row, double slice) const;
  /// Inverse: (column, row, slice).
  Vec3 PixelOf(const Vec3& index) const;
};

SliceFrame MakeSliceFrame(const GridGeometry& grid, SlicePlane plane);

/// One slice through window and level as 0xAARRGGBB, columns × rows. Slices outside are black.
void RenderSlice(const Volume& ct, const SliceFrame& frame, int slice, double window_hu,
                 double level_hu, std::vector<std::uint32_t>* pixels);

/// Blends label colours over it: their outline in full, the inside with `fill` (0..1). A colour
/// without alpha is not drawn. `labels` has the same grid.
void BlendLabels(const LabelMap& labels, const SliceFrame& frame, int slice,
                 const std::array<std::uint32_t, 256>& colors, double fill,
                 std::vector<std::uint32_t>* pixels);

/// Window and level that show a tissue.
struct WindowPreset {
  std::string name;
  double window_hu = 400, level_hu = 40;
};
const std::vector<WindowPreset>& WindowPresets();

}  // namespace kerf
