#include "Phantom/Rasterizer.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kerf {

VisibilityBuffer::VisibilityBuffer(int width_px, int height_px)
    : width(width_px),
      height(height_px),
      depth_mm(std::size_t(width_px) * height_px, std::numeric_limits<float>::infinity()),
      triangle(depth_mm.size(), -1),
      weight1(depth_mm.size(), 0.0F),
      weight2(depth_mm.size(), 0.0F) {}

void Rasterize(const SurfaceMesh& surface, const CameraModel& camera, Index first_triangle,
               VisibilityBuffer* buffer) {
  const Eigen::Index count = surface.points.rows();
  std::vector<Vec2> pixel(count);
  std::vector<double> depth(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const Vec3 p = surface.points.row(i);
    pixel[i] = camera.Project(p);
    depth[i] = camera.Depth(p);
  }
  for (Index t = 0; t < surface.triangles.rows(); ++t) {
    const Index a = surface.triangles(t, 0), b = surface.triangles(t, 1),
                c = surface.triangles(t, 2);
    if (std::min({depth[a], depth[b], depth[c]}) < 1.0) continue;
    const Vec2 &pa = pixel[a], &pb = pixel[b], &pc = pixel[c];
    const double area = (pb - pa).x() * (pc - pa).y() - (pb - pa).y() * (pc - pa).x();
    if (std::abs(area) < 1e-12) continue;
    const int u0 = std::max(0, static_cast<int>(std::ceil(std::min({pa.x(), pb.x(), pc.x()}))));
    const int u1 = std::min(buffer->width - 1,
                            static_cast<int>(std::floor(std::max({pa.x(), pb.x(), pc.x()}))));
    const int v0 = std::max(0, static_cast<int>(std::ceil(std::min({pa.y(), pb.y(), pc.y()}))));
    const int v1 = std::min(buffer->height - 1,
                            static_cast<int>(std::floor(std::max({pa.y(), pb.y(), pc.y()}))));
    for (int v = v0; v <= v1; ++v)
      for (int u = u0; u <= u1; ++u) {
        const Vec2 p(u, v);
        const double wb = ((p - pa).x() * (pc - pa).y() - (p - pa).y() * (pc - pa).x()) / area;
        const double wc = ((pb - pa).x() * (p - pa).y() - (pb - pa).y() * (p - pa).x()) / area;
        const double wa = 1.0 - wb - wc;
        // Edges belong to both neighbours, so that a closed surface has no pinholes.
        if (wa < -1e-9 || wb < -1e-9 || wc < -1e-9) continue;
        const double inverse = wa / depth[a] + wb / depth[b] + wc / depth[c];
        const double z = 1.0 / inverse;
        const std::size_t at = buffer->At(u, v);
        if (z >= buffer->depth_mm[at]) continue;
        buffer->depth_mm[at] = static_cast<float>(z);
        buffer->triangle[at] = first_triangle + t;
        buffer->weight1[at] = static_cast<float>(wb / depth[b] * z);
        buffer->weight2[at] = static_cast<float>(wc / depth[c] * z);
      }
  }
}

}  // namespace kerf
