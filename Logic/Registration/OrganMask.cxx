#include "Registration/OrganMask.h"

#include <algorithm>
#include <cmath>

namespace kerf {

Image ProjectedMask(const SurfaceMesh& surface, const CameraModel& camera) {
  Image mask;
  mask.width = camera.width;
  mask.height = camera.height;
  mask.channels = 1;
  mask.data.assign(std::size_t(mask.width) * mask.height, 0);
  Pixels projected(surface.points.rows(), 2);
  for (Index i = 0; i < surface.points.rows(); ++i)
    projected.row(i) = camera.Project(surface.points.row(i).transpose()).transpose();
  const auto cross = [](const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); };
  for (Index t = 0; t < surface.triangles.rows(); ++t) {
    const Vec2 a = projected.row(surface.triangles(t, 0)).transpose();
    const Vec2 b = projected.row(surface.triangles(t, 1)).transpose();
    const Vec2 c = projected.row(surface.triangles(t, 2)).transpose();
    if (!a.allFinite() || !b.allFinite() || !c.allFinite()) continue;
    const double left = std::min({a.x(), b.x(), c.x()}), right = std::max({a.x(), b.x(), c.x()});
    const double top = std::min({a.y(), b.y(), c.y()}), bottom = std::max({a.y(), b.y(), c.y()});
    const int u0 = static_cast<int>(std::ceil(std::max(0.0, left)));
    const int u1 = static_cast<int>(std::floor(std::min(mask.width - 1.0, right)));
    const int v0 = static_cast<int>(std::ceil(std::max(0.0, top)));
    const int v1 = static_cast<int>(std::floor(std::min(mask.height - 1.0, bottom)));
    const double area = cross(b - a, c - a);
    if (area == 0.0) continue;
    for (int v = v0; v <= v1; ++v)
      for (int u = u0; u <= u1; ++u) {
        const Vec2 p(u, v);
        const double wa = cross(b - p, c - p) / area, wb = cross(c - p, a - p) / area;
        if (wa >= 0.0 && wb >= 0.0 && wa + wb <= 1.0)
          mask.data[std::size_t(v) * mask.width + u] = 255;
      }
  }
  return mask;
}

}  // namespace kerf
