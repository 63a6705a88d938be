#pragma once

#include <cmath>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "Core/Camera.h"
#include "Core/Frame.h"
#include "Core/SurfaceMesh.h"
#include "Support/TestCameras.h"

namespace kerf::testing {

/// Sphere by subdivided octahedron, outwards.
inline SurfaceMesh Sphere(const Vec3& center, const Vec3& radii, int subdivisions = 4) {
  std::vector<Vec3> p{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  std::vector<std::array<Index, 3>> t{{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                                      {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  for (int s = 0; s < subdivisions; ++s) {
    std::map<std::pair<Index, Index>, Index> middle;
    std::vector<std::array<Index, 3>> finer;
    const auto mid = [&](Index a, Index b) {
      const auto key = std::minmax(a, b);
      const auto [it, fresh] = middle.emplace(key, static_cast<Index>(p.size()));
      if (fresh) p.push_back((p[a] + p[b]).normalized());
      return it->second;
    };
    for (const auto& [a, b, c] : t) {
      const Index ab = mid(a, b), bc = mid(b, c), ca = mid(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
    }
    t.swap(finer);
  }
  SurfaceMesh mesh;
  mesh.points.resize(static_cast<Index>(p.size()), 3);
  for (std::size_t i = 0; i < p.size(); ++i)
    mesh.points.row(static_cast<Index>(i)) = (center + p[i].cwiseProduct(radii)).transpose();
  mesh.triangles.resize(static_cast<Index>(t.size()), 3);
  for (std::size_t i = 0; i < t.size(); ++i)
    mesh.triangles.row(static_cast<Index>(i)) << t[i][0], t[i][1], t[i][2];
  return mesh;
}

/// A wide lens with strong distortion, an off-centre principal point and unequal focal lengths.
inline CameraModel StrongLens() {
  CameraModel lens;
  lens.width = 960;
  lens.height = 540;
  lens.fx = 640;
  lens.fy = 622;
  lens.cx = 441.3;
  lens.cy = 301.7;
  lens.distortion = {-0.28, 0.09, 0.003, -0.002, -0.012};
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = (Eigen::AngleAxisd(0.7, Vec3(0.3, -0.8, 0.5).normalized())).toRotationMatrix();
  pose.translation() = Vec3(4, -7, 160);
  lens.camera_from_world = pose;
  return lens;
}

inline CameraModel PlainLens(int width, int height) {
  CameraModel lens = Pinhole(width, height, 0.95 * width, Vec3(0, 0, 150));
  lens.distortion = {-0.15, 0.04, 0.0005, -0.0004, 0};
  return lens;
}

/// Something like tissue: red with smooth blobs, from a fixed formula.
inline std::shared_ptr<const Image> TissuePicture(int width, int height) {
  auto image = std::make_shared<Image>();
  image->width = width;
  image->height = height;
  image->channels = 3;
  image->data.resize(std::size_t(3) * width * height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const double u = 960.0 * x / width, v = 960.0 * y / width;
      const double blob =
          std::sin(u / 47.0 + std::sin(v / 61.0)) * std::cos(v / 53.0 - std::sin(u / 71.0));
      const double light = 0.75 + 0.2 * blob;
      std::uint8_t* out = image->data.data() + std::size_t(3) * (std::size_t(y) * width + x);
      out[0] = static_cast<std::uint8_t>(70 * light);
      out[1] = static_cast<std::uint8_t>(78 * light);
      out[2] = static_cast<std::uint8_t>(190 * light);
    }
  return image;
}

}  // namespace kerf::testing
