#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "Core/Progress.h"
#include "Core/Volume.h"

/// Work within the bounding box of labels: an organ is a small part of a CT. Private to the tools.
namespace kerf {

using LabelTest = std::function<bool(std::uint8_t)>;

/// Index box, both ends included.
struct LabelBox {
  Eigen::Vector3i low = Eigen::Vector3i::Zero(), high = -Eigen::Vector3i::Ones();

  bool Empty() const { return (high.array() < low.array()).any(); }
  Eigen::Vector3i Size() const { return high - low + Eigen::Vector3i::Ones(); }
  std::size_t Count() const {
    const Eigen::Vector3i n = Size();
    return Empty() ? 0 : std::size_t(n[0]) * n[1] * n[2];
  }
  /// Wider on all sides, cut off at the grid's border.
  void Grow(const GridGeometry& grid, double by_mm);
  /// Position in the box of a voxel of the grid, which must lie in it.
  std::size_t InBox(const GridGeometry& grid, std::size_t at) const {
    const int i = static_cast<int>(at % grid.size[0]);
    const int j = static_cast<int>(at / grid.size[0] % grid.size[1]);
    const int k = static_cast<int>(at / grid.size[0] / grid.size[1]);
    const Eigen::Vector3i n = Size();
    return (std::size_t(k - low[2]) * n[1] + (j - low[1])) * n[0] + (i - low[0]);
  }
  /// f(offset in the grid, offset in the box), x fastest.
  template <class F>
  void ForEach(const GridGeometry& grid, F f) const {
    std::size_t in_box = 0;
    for (int k = low[2]; k <= high[2]; ++k)
      for (int j = low[1]; j <= high[1]; ++j) {
        std::size_t at = grid.Offset(low[0], j, k);
        for (int i = low[0]; i <= high[0]; ++i) f(at++, in_box++);
      }
  }
  /// f(first offset in the box, stride) for every line along an axis.
  template <class F>
  void ForEachLine(int axis, F f) const {
    const Eigen::Vector3i n = Size();
    const std::size_t stride[3] = {1, std::size_t(n[0]), std::size_t(n[0]) * n[1]};
    const int a = (axis + 1) % 3, b = (axis + 2) % 3;
    for (int y = 0; y < n[b]; ++y)
      for (int x = 0; x < n[a]; ++x) f(x * stride[a] + y * stride[b], stride[axis]);
  }
};

/// Box of the voxels for which `test` holds.
LabelBox BoxOf(const LabelMap& labels, const LabelTest& test);

struct BoxComponents {
  std::vector<std::int32_t> of;    ///< per voxel of the box: 1…, 0 = test does not hold
  std::vector<std::size_t> sizes;  ///< voxels
  int Largest() const;             ///< the first of equals
};
/// Face-connected, numbered in the order of their first voxels.
BoxComponents ComponentsIn(const LabelMap& labels, const LabelBox& box, const LabelTest& test,
                           Progress& progress);
/// Components that reach a face of the box.
std::vector<char> TouchesFace(const LabelBox& box, const BoxComponents& components);

/// Exact squared Euclidean distance between voxel centres to the nearest voxel for which `test`
/// holds, over the box (Felzenszwalb and Huttenlocher 2012, anisotropic spacing).
std::vector<float> SquaredDistance_mm2(const LabelMap& labels, const LabelBox& box,
                                       const LabelTest& test, Progress& progress);

}  // namespace kerf
