#pragma once

#include "Adapters/Rendering/OverlayScene.h"
#include "SceneFixtures.h"

namespace kerf::testing {

/// A kidney-like body with an open wedge cut into its lower side, a tumour and a branching inner
/// structure: all that an overlay can show, from formulas.
struct PhantomScene {
  CameraModel lens;
  SurfaceMesh organ, tumour, internal;
  Image instruments;
  OverlayScene scene;
};

namespace detail {

inline void Append(const SurfaceMesh& part, SurfaceMesh* all) {
  const Index n = static_cast<Index>(all->points.rows()),
              t = static_cast<Index>(all->triangles.rows());
  all->points.conservativeResize(n + part.points.rows(), 3);
  all->points.bottomRows(part.points.rows()) = part.points;
  all->triangles.conservativeResize(t + part.triangles.rows(), 3);
  all->triangles.bottomRows(part.triangles.rows()) = part.triangles.array() + n;
}

}  // namespace detail

inline PhantomScene MakePhantomScene(int width, int height) {
  PhantomScene s;
  s.lens = PlainLens(width, height);
  s.lens.camera_from_world.linear() =
      (Eigen::AngleAxisd(0.5, Vec3::UnitY()) * Eigen::AngleAxisd(-0.25, Vec3::UnitX()))
          .toRotationMatrix();
  const Vec3 radii(48, 25, 20);
  SurfaceMesh body = Sphere(Vec3::Zero(), radii, 5);
  // Everything right of the middle slides to the right, the more the lower: the wedge opens. Faces
  // join its two sides.
  const auto opening = [](double y) { return y > 0 ? 0.3 * y : 0.0; };
  std::vector<Index> kept;
  for (Index t = 0; t < body.triangles.rows(); ++t) {
    int right = 0;
    double y = 0;
    for (int k = 0; k < 3; ++k) {
      right += body.points(body.triangles(t, k), 0) > 0;
      y += body.points(body.triangles(t, k), 1) / 3;
    }
    if (right == 0 || right == 3 || y < 0) kept.push_back(t);
  }
  Triangles outer(static_cast<Index>(kept.size()), 3);
  for (std::size_t i = 0; i < kept.size(); ++i)
    outer.row(static_cast<Index>(i)) = body.triangles.row(kept[i]);
  body.triangles = outer;
  for (Index i = 0; i < body.points.rows(); ++i) {
    const double y = body.points(i, 1);
    body.points(i, 0) += (body.points(i, 0) > 0 ? 1 : -1) * opening(y);
  }
  s.organ = body;
  s.scene.organ_cut_face.assign(static_cast<std::size_t>(outer.rows()), 0);
  for (int side : {-1, 1}) {
    const int n = 24;
    SurfaceMesh face;
    face.points.resize((n + 1) * (n + 1), 3);
    face.triangles.resize(2 * n * n, 3);
    Index t = 0;
    for (int i = 0; i <= n; ++i)
      for (int j = 0; j <= n; ++j) {
        const double y = radii.y() * 0.999 * i / n;
        const double z = radii.z() * std::sqrt(1 - std::pow(y / radii.y(), 2)) * (2.0 * j / n - 1);
        face.points.row(i * (n + 1) + j) << side * (0.3 + opening(y)), y, z;
        if (i == n || j == n) continue;
        const Index a = i * (n + 1) + j;
        face.triangles.row(t++) << a, a + 1, a + n + 1;
        face.triangles.row(t++) << a + 1, a + n + 2, a + n + 1;
      }
    detail::Append(face, &s.organ);
    s.scene.organ_cut_face.insert(s.scene.organ_cut_face.end(), static_cast<std::size_t>(t), 1);
  }
  s.tumour = Sphere(Vec3(-26, 4, -9), Vec3(7, 6, 5), 4);
  for (int b = 0; b < 5; ++b)
    detail::Append(Sphere(Vec3(-14 + 9 * b, -6 + 3 * (b % 2), 2), Vec3(6.5, 2.6, 2.6), 3),
                   &s.internal);
  detail::Append(Sphere(Vec3(4, -7, 2), Vec3(24, 2.2, 2.2), 4), &s.internal);

  s.instruments.width = width;
  s.instruments.height = height;
  s.instruments.channels = 1;
  s.instruments.data.assign(std::size_t(width) * height, 0);
  auto picture = std::make_shared<Image>(*TissuePicture(width, height));
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      // A steel shaft from the lower right corner.
      const double along = 0.6 * x + 0.8 * (height - y) - 0.35 * width;
      const double across = std::abs(0.8 * (x - 0.62 * width) - 0.6 * (y - 0.55 * height));
      if (across > 0.022 * width || x < 0.62 * width || along < 0) continue;
      s.instruments.data[std::size_t(y) * width + x] = 255;
      const int steel = 210 - static_cast<int>(3200 * across / width);
      for (int k = 0; k < 3; ++k)
        picture->data[3 * (std::size_t(y) * width + x) + k] = static_cast<std::uint8_t>(steel);
    }
  s.scene.frame = {81, 3.24, picture};
  s.scene.status.tumour_u95_mm = 3.0;
  return s;
}

/// The scene borrows from the struct: call this where the struct has come to rest.
inline const OverlayScene& Bind(PhantomScene* s) {
  s->scene.organ = &s->organ;
  s->scene.structures = {{OverlayStructure::Kind::Tumour, &s->tumour},
                         {OverlayStructure::Kind::Internal, &s->internal}};
  s->scene.instruments = &s->instruments;
  return s->scene;
}

}  // namespace kerf::testing
