#include "Adapters/Itk/Parts.h"

#include <array>

namespace kerf {
namespace {

class Union {
 public:
  int Make(float peak) {
    parent_.push_back(static_cast<int>(parent_.size()));
    peak_.push_back(peak);
    return parent_.back();
  }
  int Find(int x) {
    while (parent_[x] != x) x = parent_[x] = parent_[parent_[x]];
    return x;
  }
  /// The deeper one stays the root; the older one where equal.
  int Merge(int a, int b) {
    if (peak_[b] > peak_[a] || (peak_[b] == peak_[a] && b < a)) std::swap(a, b);
    parent_[b] = a;
    return a;
  }
  float Peak(int root) const { return peak_[root]; }

 private:
  std::vector<int> parent_;
  std::vector<float> peak_;
};

/// Offsets of the 26 neighbours that exist.
int Neighbors(const GridGeometry& grid, std::size_t at, std::array<std::size_t, 26>* out) {
  const auto& s = grid.size;
  const int x = int(at % s[0]), y = int(at / s[0] % s[1]), z = int(at / (std::size_t(s[0]) * s[1]));
  int n = 0;
  for (int dz = -1; dz <= 1; ++dz)
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx) {
        if (dx == 0 && dy == 0 && dz == 0) continue;
        const int i = x + dx, j = y + dy, k = z + dz;
        if (i < 0 || j < 0 || k < 0 || i >= s[0] || j >= s[1] || k >= s[2]) continue;
        (*out)[n++] = grid.Offset(i, j, k);
      }
  return n;
}

}  // namespace

Field<std::int32_t> DivideAtNecks(const ScalarField& depth_mm, double neck_ratio,
                                  double tolerance_mm) {
  const auto& depth = depth_mm.values;
  std::vector<std::uint32_t> order;
  for (std::size_t i = 0; i < depth.size(); ++i)
    if (depth[i] > 0) order.push_back(static_cast<std::uint32_t>(i));
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return depth[a] != depth[b] ? depth[a] > depth[b] : a < b;
  });
  Field<std::int32_t> part(depth_mm.grid, -1);
  Union parts;
  std::array<std::size_t, 26> near{};
  for (const std::size_t at : order) {
    const int n = Neighbors(depth_mm.grid, at, &near);
    // The steepest way up decides where the voxel belongs, whatever merges here.
    int own = -1;
    float steepest = -1;
    for (int k = 0; k < n; ++k)
      if (part.values[near[k]] >= 0 && depth[near[k]] > steepest) {
        steepest = depth[near[k]];
        own = part.values[near[k]];
      }
    if (own < 0) {
      part.values[at] = parts.Make(depth[at]);
      continue;
    }
    part.values[at] = own = parts.Find(own);
    for (int k = 0; k < n; ++k) {
      if (part.values[near[k]] < 0) continue;
      const int other = parts.Find(part.values[near[k]]);
      own = parts.Find(own);
      if (other == own) continue;
      const double thinner = std::min(parts.Peak(own), parts.Peak(other));
      if (depth[at] >= neck_ratio * thinner || thinner - depth[at] < tolerance_mm)
        parts.Merge(own, other);
    }
  }
  for (auto& p : part.values)
    if (p >= 0) p = parts.Find(p);
  return part;
}

}  // namespace kerf
