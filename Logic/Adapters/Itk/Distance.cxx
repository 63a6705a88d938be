#include <cmath>
#include <limits>

#include "Adapters/Itk/Field.h"
#include "Adapters/Itk/Parallel.h"

/// The exact distance transform of Maurer, Qi and Raghavan (2003), line by line along one axis
/// after the other, in the precision of itk::SignedMaurerDistanceMapImageFilter, whose bits these
/// are. Lines are gathered in blocks, so that memory is read along its rows: a third of that
/// filter's time.
namespace kerf {
namespace {

constexpr float kFar = std::numeric_limits<float>::max();  ///< nothing was met yet

/// Set voxels with an unset one among their 26 neighbours get 0, all others kFar.
std::vector<float> Border(const Mask& mask) {
  const auto& size = mask.grid.size;
  std::vector<float> border(mask.values.size());
  itk_bridge::ParallelFor(size[2], [&](int k) {
    const auto touches = [&](int i, int j) {
      for (int c = std::max(0, k - 1); c <= std::min(size[2] - 1, k + 1); ++c)
        for (int b = std::max(0, j - 1); b <= std::min(size[1] - 1, j + 1); ++b)
          for (int a = std::max(0, i - 1); a <= std::min(size[0] - 1, i + 1); ++a)
            if (!mask.values[mask.grid.Offset(a, b, c)]) return true;
      return false;
    };
    std::size_t at = mask.grid.Offset(0, 0, k);
    for (int j = 0; j < size[1]; ++j)
      for (int i = 0; i < size[0]; ++i, ++at)
        border[at] = mask.values[at] && touches(i, j) ? 0.f : kFar;
  });
  return border;
}

/// One line: from squared distances within the lower dimensions to those with this one.
class Line {
 public:
  Line(int size, double spacing_mm) : size_(size), site_(size), place_(size) {
    for (int i = 0; i < size; ++i) {
      given_.push_back(static_cast<float>(i) * static_cast<float>(spacing_mm));
      wanted_.push_back(static_cast<float>(i * spacing_mm));
    }
  }
  /// @param squared in place, with any sign, `stride` apart
  void Run(float* squared, int stride) {
    int last = -1;
    for (int i = 0; i < size_; ++i) {
      const float d = squared[std::ptrdiff_t(i) * stride];
      if (d == kFar) continue;
      if (last >= 1)
        while (last >= 1 && Hidden(site_[last - 1], site_[last], std::abs(d), place_[last - 1],
                                   place_[last], given_[i]))
          --last;
      ++last;
      site_[last] = std::abs(d);
      place_[last] = given_[i];
    }
    if (last < 0) return;
    int l = 0;
    for (int i = 0; i < size_; ++i) {
      const float x = wanted_[i];
      float nearest = site_[l] + (place_[l] - x) * (place_[l] - x);
      while (l < last) {
        const float next = site_[l + 1] + (place_[l + 1] - x) * (place_[l + 1] - x);
        if (nearest <= next) break;
        ++l;
        nearest = next;
      }
      squared[std::ptrdiff_t(i) * stride] = nearest;
    }
  }

 private:
  /// The middle one of three sites is nowhere the nearest.
  static bool Hidden(float d1, float d2, float df, float x1, float x2, float xf) {
    const float a = x2 - x1, b = xf - x2, c = xf - x1;
    return c * d2 - b * d1 - a * df - a * b * c > 0;
  }

  int size_;
  std::vector<float> site_, place_, given_, wanted_;
};

/// Lines across rows, `stride` apart: a block of columns at a time.
void AcrossRows(float* first, int columns, int size, std::size_t stride, double spacing_mm) {
  constexpr int kBlock = 16;
  Line line(size, spacing_mm);
  std::vector<float> block(std::size_t(size) * kBlock);
  for (int from = 0; from < columns; from += kBlock) {
    const int n = std::min(kBlock, columns - from);
    for (int r = 0; r < size; ++r)
      std::copy_n(first + r * stride + from, n, &block[std::size_t(r) * kBlock]);
    for (int c = 0; c < n; ++c) line.Run(&block[c], kBlock);
    for (int r = 0; r < size; ++r)
      std::copy_n(&block[std::size_t(r) * kBlock], n, first + r * stride + from);
  }
}

}  // namespace

ScalarField SignedDistance_mm(const Mask& mask) {
  const std::size_t count = Count(mask);
  if (count == 0) return ScalarField(mask.grid, -1e6f);
  if (count == mask.values.size()) return ScalarField(mask.grid, 1e6f);
  ScalarField out;
  out.grid = mask.grid;
  out.values = Border(mask);
  const auto& size = mask.grid.size;
  const auto& spacing = mask.grid.spacing_mm;
  float* d = out.values.data();
  const std::size_t row = size[0], slice = row * size[1];
  itk_bridge::ParallelFor(size[2], [&](int k) {
    Line line(size[0], spacing[0]);
    for (int j = 0; j < size[1]; ++j) line.Run(d + k * slice + j * row, 1);
    AcrossRows(d + k * slice, size[0], size[1], row, spacing[1]);
  });
  itk_bridge::ParallelFor(
      size[1], [&](int j) { AcrossRows(d + j * row, size[0], size[2], slice, spacing[2]); });
  // Measured so far is from the centres of the object's outermost voxels: the boundary is half a
  // voxel on.
  const float half = float(0.5 * std::cbrt(spacing.prod()));
  itk_bridge::ParallelFor(size[2], [&](int k) {
    for (std::size_t at = k * slice; at < (k + 1) * slice; ++at)
      d[at] = (mask.values[at] ? std::sqrt(d[at]) : -std::sqrt(d[at])) + half;
  });
  return out;
}

}  // namespace kerf
