#include "Session/PlanningSlice.h"

#include <algorithm>
#include <cmath>

namespace kerf {
namespace {

/// Grid axes that are nearest to patient left, posterior, superior: each used once.
std::array<int, 3> AnatomicalAxes(const Mat3& direction) {
  std::array<int, 3> best{0, 1, 2}, candidate{0, 1, 2};
  double best_sum = -1;
  do {
    double sum = 0;
    for (int a = 0; a < 3; ++a) sum += std::abs(direction(a, candidate[a]));
    if (sum > best_sum + 1e-9) best_sum = sum, best = candidate;
  } while (std::next_permutation(candidate.begin(), candidate.end()));
  return best;
}

std::uint32_t Blend(std::uint32_t under, std::uint32_t over, double alpha) {
  std::uint32_t mixed = 0xff000000u;
  for (const int shift : {0, 8, 16}) {
    const double a = (under >> shift) & 255u, b = (over >> shift) & 255u;
    mixed |= static_cast<std::uint32_t>(a + (b - a) * alpha + 0.5) << shift;
  }
  return mixed;
}

/// Where voxels of a slice lie in the array: offset = origin + column · du + row · dv.
struct Walk {
  std::ptrdiff_t origin, du, dv;
};

Walk WalkOf(const GridGeometry& grid, const SliceFrame& f, int slice) {
  const std::array<std::ptrdiff_t, 3> stride{1, grid.size[0],
                                             std::ptrdiff_t(grid.size[0]) * grid.size[1]};
  Walk w{slice * stride[f.n_axis], stride[f.u_axis], stride[f.v_axis]};
  if (f.flip_u) w.origin += (f.columns - 1) * w.du, w.du = -w.du;
  if (f.flip_v) w.origin += (f.rows - 1) * w.dv, w.dv = -w.dv;
  return w;
}

}  // namespace

Vec3 SliceFrame::IndexOf(double column, double row, double slice) const {
  Vec3 index;
  index[u_axis] = flip_u ? columns - 1 - column : column;
  index[v_axis] = flip_v ? rows - 1 - row : row;
  index[n_axis] = slice;
  return index;
}

Vec3 SliceFrame::PixelOf(const Vec3& index) const {
  return {flip_u ? columns - 1 - index[u_axis] : index[u_axis],
          flip_v ? rows - 1 - index[v_axis] : index[v_axis], index[n_axis]};
}

SliceFrame MakeSliceFrame(const GridGeometry& grid, SlicePlane plane) {
  const std::array<int, 3> axes = AnatomicalAxes(grid.direction);
  // World axis to the right and downwards, and whether its positive way (L, P, S) is meant.
  const int right = plane == SlicePlane::Sagittal ? 1 : 0;
  const int down = plane == SlicePlane::Axial ? 1 : 2;
  const int through = 3 - right - down;
  SliceFrame f;
  f.plane = plane;
  f.u_axis = axes[right];
  f.v_axis = axes[down];
  f.n_axis = axes[through];
  f.flip_u = grid.direction(right, f.u_axis) < 0;
  f.flip_v = (grid.direction(down, f.v_axis) < 0) != (down == 2);
  f.columns = grid.size[f.u_axis];
  f.rows = grid.size[f.v_axis];
  f.slices = grid.size[f.n_axis];
  f.spacing_u_mm = grid.spacing_mm[f.u_axis];
  f.spacing_v_mm = grid.spacing_mm[f.v_axis];
  f.spacing_n_mm = grid.spacing_mm[f.n_axis];
  f.left = right == 0 ? "R" : "A";
  f.right = right == 0 ? "L" : "P";
  f.top = down == 1 ? "A" : "S";
  f.bottom = down == 1 ? "P" : "I";
  return f;
}

void RenderSlice(const Volume& ct, const SliceFrame& f, int slice, double window_hu,
                 double level_hu, std::vector<std::uint32_t>* pixels) {
  pixels->assign(std::size_t(f.columns) * f.rows, 0xff000000u);
  if (slice < 0 || slice >= f.slices || !ct.voxels) return;
  // A table over all values that int16 has: one look-up per pixel.
  thread_local std::vector<std::uint32_t> table;
  thread_local double table_window = -1, table_level = 0;
  if (table.empty() || table_window != window_hu || table_level != level_hu) {
    table.resize(65536);
    for (int v = 0; v < 65536; ++v) {
      const double t = (v - 32768 - level_hu) / std::max(1.0, window_hu) + 0.5;
      const auto g = static_cast<std::uint32_t>(255.0 * std::clamp(t, 0.0, 1.0) + 0.5);
      table[v] = 0xff000000u | g << 16 | g << 8 | g;
    }
    table_window = window_hu;
    table_level = level_hu;
  }
  const Walk w = WalkOf(ct.grid, f, slice);
  const std::int16_t* voxels = ct.voxels->data();
  std::uint32_t* out = pixels->data();
  for (int row = 0; row < f.rows; ++row) {
    const std::int16_t* v = voxels + w.origin + row * w.dv;
    for (int column = 0; column < f.columns; ++column, v += w.du) *out++ = table[*v + 32768];
  }
}

void BlendLabels(const LabelMap& labels, const SliceFrame& f, int slice,
                 const std::array<std::uint32_t, 256>& colors, double fill,
                 std::vector<std::uint32_t>* pixels) {
  if (slice < 0 || slice >= f.slices || !labels.voxels) return;
  if (pixels->size() != std::size_t(f.columns) * f.rows) return;
  const Walk w = WalkOf(labels.grid, f, slice);
  const std::uint8_t* voxels = labels.voxels->data();
  std::uint32_t* out = pixels->data();
  for (int row = 0; row < f.rows; ++row) {
    const std::uint8_t* v = voxels + w.origin + row * w.dv;
    for (int column = 0; column < f.columns; ++column, v += w.du, ++out) {
      const std::uint8_t label = *v;
      if (label == 0 || (colors[label] >> 24) == 0) continue;
      const bool edge = column == 0 || column == f.columns - 1 || row == 0 || row == f.rows - 1 ||
                        v[w.du] != label || v[-w.du] != label || v[w.dv] != label ||
                        v[-w.dv] != label;
      *out = Blend(*out, colors[label], edge ? 1.0 : fill);
    }
  }
}

const std::vector<WindowPreset>& WindowPresets() {
  static const std::vector<WindowPreset> presets{{"Abdomen", 400, 40}, {"Liver", 150, 60},
                                                 {"Kidney", 300, 120}, {"Vessels", 600, 250},
                                                 {"Bone", 1800, 400},  {"Lung", 1500, -600}};
  return presets;
}

}  // namespace kerf
