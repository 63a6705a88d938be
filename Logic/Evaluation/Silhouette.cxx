#include "Evaluation/Silhouette.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

namespace kerf {
namespace {

constexpr int kSamples = 4;             // per pixel and direction
constexpr std::int64_t kFraction = 16;  // corners are rounded to 1/16 of a sample

/// Corner in sixteenths of a sample; sample centres at integers.
struct Corner {
  std::int64_t x = 0, y = 0;
};

class SampleGrid {
 public:
  SampleGrid(int width, int height)
      : width_(width * kSamples),
        height_(height * kSamples),
        covered_(std::size_t(width_) * height_, 0) {}

  void Fill(const std::array<Corner, 3>& t) {
    for (int k = 0; k < 3; ++k) DrawEdge(t[k], t[(k + 1) % 3]);
    const auto [low, high] = std::minmax({t[0].y, t[1].y, t[2].y});
    const std::int64_t first = std::max<std::int64_t>(0, CeilDivide(low));
    const std::int64_t last = std::min<std::int64_t>(height_ - 1, FloorDivide(high));
    for (std::int64_t row = first; row <= last; ++row) FillRow(t, row);
  }

  Image HalfCovered() const {
    Image image{width_ / kSamples, height_ / kSamples, 1, {}};
    image.data.assign(std::size_t(image.width) * image.height, 0);
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x) {
        int count = 0;
        for (int j = 0; j < kSamples; ++j)
          for (int i = 0; i < kSamples; ++i)
            count += covered_[std::size_t(y * kSamples + j) * width_ + x * kSamples + i];
        if (2 * count >= kSamples * kSamples) image.data[std::size_t(y) * image.width + x] = 255;
      }
    return image;
  }

 private:
  static std::int64_t FloorDivide(std::int64_t v) {
    return v >= 0 ? v / kFraction : -((-v + kFraction - 1) / kFraction);
  }
  static std::int64_t CeilDivide(std::int64_t v) { return -FloorDivide(-v); }

  /// Samples whose centre lies in the triangle on this row.
  void FillRow(const std::array<Corner, 3>& t, std::int64_t row) {
    const double y = static_cast<double>(row * kFraction);
    double left = 1e300, right = -1e300;
    for (int k = 0; k < 3; ++k) {
      const Corner &a = t[k], &b = t[(k + 1) % 3];
      if (std::min(a.y, b.y) > row * kFraction || std::max(a.y, b.y) < row * kFraction) continue;
      if (a.y == b.y) {
        left = std::min(left, static_cast<double>(std::min(a.x, b.x)));
        right = std::max(right, static_cast<double>(std::max(a.x, b.x)));
      } else {
        const double x = a.x + (b.x - a.x) * ((y - a.y) / static_cast<double>(b.y - a.y));
        left = std::min(left, x);
        right = std::max(right, x);
      }
    }
    const auto first =
        std::max<std::int64_t>(0, static_cast<std::int64_t>(std::ceil(left / kFraction)));
    const auto last = std::min<std::int64_t>(
        width_ - 1, static_cast<std::int64_t>(std::floor(right / kFraction)));
    if (first <= last)
      std::fill(covered_.begin() + row * width_ + first, covered_.begin() + row * width_ + last + 1,
                1);
  }

  /// The outline itself, one sample per step: slivers thinner than a sample are seen, and
  /// neighbours close without a gap.
  void DrawEdge(const Corner& a, const Corner& b) {
    const bool steep = std::abs(b.y - a.y) > std::abs(b.x - a.x);
    auto along = [&](const Corner& c) {
      return static_cast<double>(steep ? c.y : c.x) / kFraction;
    };
    auto across = [&](const Corner& c) {
      return static_cast<double>(steep ? c.x : c.y) / kFraction;
    };
    const Corner &p = along(a) <= along(b) ? a : b, &q = along(a) <= along(b) ? b : a;
    const double length = along(q) - along(p);
    const double slope = length > 0 ? (across(q) - across(p)) / length : 0.0;
    const double limit = steep ? height_ - 1 : width_ - 1;
    const double first = std::max(0.0, std::floor(along(p) + 0.5));
    const double last = std::min(limit, std::floor(along(q) + 0.5));
    for (double s = first; s <= last; s += 1.0) {
      const double inside = std::clamp(s, along(p), along(q));
      const double c = std::floor(across(p) + slope * (inside - along(p)) + 0.5);
      if (c < 0 || c >= (steep ? width_ : height_)) continue;
      const auto x = static_cast<std::size_t>(steep ? c : s),
                 y = static_cast<std::size_t>(steep ? s : c);
      covered_[y * width_ + x] = 1;
    }
  }

  int width_, height_;
  std::vector<std::uint8_t> covered_;
};

}  // namespace

Image Silhouette(const CameraModel& camera, const SurfaceMesh& surface) {
  const Index n = static_cast<Index>(surface.points.rows());
  std::vector<Corner> corners(n);
  std::vector<char> usable(n, 0);
  for (Index i = 0; i < n; ++i) {
    const Vec3 c = camera.camera_from_world * Vec3(surface.points.row(i).transpose());
    if (!(c.z() > 1.0)) continue;
    const Vec2 pixel = camera.Distort({c.x() / c.z(), c.y() / c.z()});
    if (!pixel.allFinite()) continue;
    const auto rounded = [](double p) {
      const double v = std::nearbyint(((p + 0.5) * kSamples - 0.5) * kFraction);
      return static_cast<std::int64_t>(std::clamp(v, -1e6, 1e6));
    };
    corners[i] = {rounded(pixel.x()), rounded(pixel.y())};
    usable[i] = 1;
  }
  SampleGrid grid(camera.width, camera.height);
  for (Index t = 0; t < surface.triangles.rows(); ++t) {
    const auto v = surface.triangles.row(t);
    if (usable[v[0]] && usable[v[1]] && usable[v[2]])
      grid.Fill({corners[v[0]], corners[v[1]], corners[v[2]]});
  }
  return grid.HalfCovered();
}

double Dice(const Image& a, const Image& b) {
  if (a.width != b.width || a.height != b.height || a.channels != 1 || b.channels != 1)
    throw std::invalid_argument("Dice: two grey images of the same size are wanted");
  std::size_t both = 0, sum = 0;
  for (std::size_t i = 0; i < a.data.size(); ++i) {
    both += a.data[i] && b.data[i];
    sum += (a.data[i] != 0) + (b.data[i] != 0);
  }
  return sum == 0 ? 1.0 : 2.0 * static_cast<double>(both) / static_cast<double>(sum);
}

}  // namespace kerf
