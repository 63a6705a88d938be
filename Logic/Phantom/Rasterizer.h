#pragma once

#include <vector>

#include "Core/Camera.h"
#include "Core/SurfaceMesh.h"

namespace kerf {

/// Visibility buffer: what each pixel centre sees, through the exact (distorting) camera.
struct VisibilityBuffer {
  VisibilityBuffer(int width_px, int height_px);
  int width, height;
  std::vector<float> depth_mm;  ///< camera z of the nearest surface; +infinity where nothing is
  std::vector<Index> triangle;  ///< −1 where nothing is
  std::vector<float> weight1,
      weight2;  ///< perspective-correct barycentric weights of vertices 1 and 2

  std::size_t At(int u, int v) const { return std::size_t(v) * width + u; }
  bool Hit(std::size_t pixel) const { return triangle[pixel] >= 0; }
};

/// Draws a surface (points in world coordinates) into the buffer; triangles are numbered from
/// `first_triangle`. Triangles that reach behind the camera are left out. Edges are straight
/// between distorted vertices: keep triangles small (a few mm).
void Rasterize(const SurfaceMesh& world_surface, const CameraModel& camera, Index first_triangle,
               VisibilityBuffer* buffer);

}  // namespace kerf
