#include "Session/PlanningBox.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace kerf {

void LabelBox::Grow(const GridGeometry& grid, double by_mm) {
  for (int a = 0; a < 3; ++a) {
    const int n = static_cast<int>(std::ceil(by_mm / grid.spacing_mm[a]));
    low[a] = std::max(0, low[a] - n);
    high[a] = std::min(grid.size[a] - 1, high[a] + n);
  }
}

LabelBox BoxOf(const LabelMap& labels, const LabelTest& test) {
  // The test as a table: the loop runs over the whole CT.
  std::array<char, 256> holds{};
  for (int v = 0; v < 256; ++v) holds[v] = test(static_cast<std::uint8_t>(v));
  const Eigen::Vector3i& n = labels.grid.size;
  LabelBox box;
  box.low = n;
  const std::uint8_t* v = labels.voxels->data();
  for (int k = 0; k < n[2]; ++k)
    for (int j = 0; j < n[1]; ++j) {
      int first = -1, last = -1;
      for (int i = 0; i < n[0]; ++i, ++v)
        if (holds[*v]) {
          if (first < 0) first = i;
          last = i;
        }
      if (first < 0) continue;
      box.low = box.low.cwiseMin(Eigen::Vector3i(first, j, k));
      box.high = box.high.cwiseMax(Eigen::Vector3i(last, j, k));
    }
  return box;
}

int BoxComponents::Largest() const {
  return static_cast<int>(std::max_element(sizes.begin(), sizes.end()) - sizes.begin()) + 1;
}

BoxComponents ComponentsIn(const LabelMap& labels, const LabelBox& box, const LabelTest& test,
                           Progress& progress) {
  BoxComponents result;
  std::vector<std::int32_t>& of = result.of;
  of.assign(box.Count(), 0);
  box.ForEach(labels.grid, [&](std::size_t at, std::size_t in_box) {
    if (test((*labels.voxels)[at])) of[in_box] = -1;
  });
  const Eigen::Vector3i n = box.Size();
  const std::ptrdiff_t row = n[0], slice = std::ptrdiff_t(n[0]) * n[1];
  std::vector<std::size_t> front;
  for (std::size_t start = 0; start < of.size(); ++start) {
    if (of[start] != -1) continue;
    progress.ThrowIfCancelled();
    const auto number = static_cast<std::int32_t>(result.sizes.size() + 1);
    std::size_t size = 0;
    front.assign(1, start);
    of[start] = number;
    while (!front.empty()) {
      const std::size_t p = front.back();
      front.pop_back();
      ++size;
      const int i = static_cast<int>(p % n[0]), j = static_cast<int>(p / n[0] % n[1]),
                k = static_cast<int>(p / slice);
      const auto visit = [&](bool inside, std::ptrdiff_t step) {
        if (inside && of[p + step] == -1) of[p + step] = number, front.push_back(p + step);
      };
      visit(i > 0, -1);
      visit(i + 1 < n[0], 1);
      visit(j > 0, -row);
      visit(j + 1 < n[1], row);
      visit(k > 0, -slice);
      visit(k + 1 < n[2], slice);
    }
    result.sizes.push_back(size);
  }
  return result;
}

std::vector<char> TouchesFace(const LabelBox& box, const BoxComponents& components) {
  std::vector<char> touches(components.sizes.size(), 0);
  const Eigen::Vector3i n = box.Size();
  std::size_t at = 0;
  for (int k = 0; k < n[2]; ++k)
    for (int j = 0; j < n[1]; ++j)
      for (int i = 0; i < n[0]; ++i, ++at) {
        const bool face =
            i == 0 || j == 0 || k == 0 || i == n[0] - 1 || j == n[1] - 1 || k == n[2] - 1;
        if (face && components.of[at] > 0) touches[components.of[at] - 1] = 1;
      }
  return touches;
}

std::vector<float> SquaredDistance_mm2(const LabelMap& labels, const LabelBox& box,
                                       const LabelTest& test, Progress& progress) {
  constexpr float kFar = 1e12f;
  std::vector<float> field(box.Count(), kFar);
  box.ForEach(labels.grid, [&](std::size_t at, std::size_t in_box) {
    if (test((*labels.voxels)[at])) field[in_box] = 0;
  });
  const Eigen::Vector3i n = box.Size();
  std::vector<double> value, bound;
  std::vector<int> vertex;
  for (int axis = 0; axis < 3; ++axis) {
    progress.ThrowIfCancelled();
    progress.Report(axis / 3.0, "distances");
    const int length = n[axis];
    const double h2 = labels.grid.spacing_mm[axis] * labels.grid.spacing_mm[axis];
    value.resize(length);
    vertex.resize(length);
    bound.resize(length + 1);
    // Lower envelope of the parabolas value[q] + h² (x − q)².
    box.ForEachLine(axis, [&](std::size_t first, std::size_t stride) {
      for (int i = 0; i < length; ++i) value[i] = field[first + i * stride];
      int k = 0;
      vertex[0] = 0;
      bound[0] = -std::numeric_limits<double>::infinity();
      bound[1] = std::numeric_limits<double>::infinity();
      for (int q = 1; q < length; ++q) {
        double s;
        for (;;) {
          const int p = vertex[k];
          s = ((value[q] / h2 + double(q) * q) - (value[p] / h2 + double(p) * p)) / (2.0 * (q - p));
          if (s > bound[k]) break;
          --k;
        }
        vertex[++k] = q;
        bound[k] = s;
        bound[k + 1] = std::numeric_limits<double>::infinity();
      }
      k = 0;
      for (int x = 0; x < length; ++x) {
        while (bound[k + 1] < x) ++k;
        const double d = x - vertex[k];
        field[first + x * stride] = static_cast<float>(value[vertex[k]] + h2 * d * d);
      }
    });
  }
  return field;
}

}  // namespace kerf
