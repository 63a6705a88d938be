#include "Registration/OrganMask.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace kerf {

namespace {

/// Pixel centres of one row inside a triangle that turns the positive way round: each side is the
/// half plane cross(q − p, x − p) ≥ 0. @return first and last column, last < first where none
std::pair<int, int> RowInside(const Vec2 corner[3], int row, int width) {
  constexpr double kTouch_px = 1e-9;  // a shared side leaves no pixel out
  double left = 0.0, right = width - 1.0;
  for (int k = 0; k < 3; ++k) {
    const Vec2& p = corner[k];
    const Vec2 d = corner[(k + 1) % 3] - p;
    const double at = d.x() * (row - p.y()) + d.y() * p.x();  // d.y · column where it crosses
    if (d.y() > 0.0)
      right = std::min(right, at / d.y() + kTouch_px);
    else if (d.y() < 0.0)
      left = std::max(left, at / d.y() - kTouch_px);
    else if (at < 0.0)
      return {0, -1};
  }
  return {static_cast<int>(std::ceil(left)), static_cast<int>(std::floor(right))};
}

}  // namespace

Image ProjectedMask(const SurfaceMesh& surface, const CameraModel& camera) {
  Image mask;
  mask.width = camera.width;
  mask.height = camera.height;
  mask.channels = 1;
  mask.data.assign(std::size_t(mask.width) * mask.height, 0);
  std::vector<char> is_used(surface.points.rows(), 0);
  for (Index t = 0; t < surface.triangles.rows(); ++t)
    for (int k = 0; k < 3; ++k) is_used[surface.triangles(t, k)] = 1;
  Pixels projected(surface.points.rows(), 2);
  for (Index i = 0; i < surface.points.rows(); ++i)
    if (is_used[i])
      projected.row(i) = camera.Project(surface.points.row(i).transpose()).transpose();
  for (Index t = 0; t < surface.triangles.rows(); ++t) {
    Vec2 corner[3];
    for (int k = 0; k < 3; ++k) corner[k] = projected.row(surface.triangles(t, k)).transpose();
    if (!corner[0].allFinite() || !corner[1].allFinite() || !corner[2].allFinite()) continue;
    const Vec2 ab = corner[1] - corner[0], ac = corner[2] - corner[0];
    const double area = ab.x() * ac.y() - ab.y() * ac.x();
    if (area == 0.0) continue;
    if (area < 0.0) std::swap(corner[1], corner[2]);
    const auto [top, bottom] = std::minmax({corner[0].y(), corner[1].y(), corner[2].y()});
    const int last = static_cast<int>(std::floor(std::min(mask.height - 1.0, bottom)));
    for (int v = static_cast<int>(std::ceil(std::max(0.0, top))); v <= last; ++v) {
      const auto [begin, end] = RowInside(corner, v, mask.width);
      if (begin > end) continue;
      const auto row = mask.data.begin() + std::ptrdiff_t(v) * mask.width;
      std::fill(row + begin, row + end + 1, std::uint8_t{255});
    }
  }
  return mask;
}

}  // namespace kerf
