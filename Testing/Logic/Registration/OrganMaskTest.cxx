// The projection against a pixel by pixel test, and the search beside other work.
#include <gtest/gtest.h>

#include <stdexcept>

#include "Registration/OrganMask.h"
#include "Registration/OrganSearch.h"
#include "Support/TestCameras.h"
#include "Support/TestMeshes.h"

namespace kerf {
namespace {

CameraModel SomeCamera() {
  CameraModel camera = testing::Pinhole(160, 100, 150);
  camera.cx = 75.3;
  camera.cy = 49.1;
  camera.distortion = {-0.2, 0.05, 0.001, -0.002, 0.0};
  camera.camera_from_world =
      Eigen::Translation3d(4, -3, 120) * Eigen::AngleAxisd(0.7, Vec3(1, 2, -1).normalized());
  return camera;
}

bool Inside(const Vec2& p, const Vec2& a, const Vec2& b, const Vec2& c) {
  const auto cross = [](const Vec2& u, const Vec2& v) { return u.x() * v.y() - u.y() * v.x(); };
  const double area = cross(b - a, c - a);
  const double wa = cross(b - p, c - p) / area, wb = cross(c - p, a - p) / area;
  return area != 0.0 && wa >= 0.0 && wb >= 0.0 && wa + wb <= 1.0;
}

TEST(ProjectedMask, CoversThePixelCentresInsideATriangle) {
  const CameraModel camera = SomeCamera();
  const TetMesh mesh = testing::EllipsoidMesh({51.0, 27.5, 13.5}, 3);
  for (const double away : {0.0, 90.0}) {  // wholly and partly in the image
    SurfaceMesh surface = BoundarySurface(mesh, mesh.rest);
    surface.points.rowwise() += Eigen::RowVector3d(away, 0, 0);
    const Image mask = ProjectedMask(surface, camera);
    ASSERT_EQ(mask.data.size(), 160u * 100u);
    std::vector<Vec2> pixel;
    for (Index i = 0; i < surface.points.rows(); ++i)
      pixel.push_back(camera.Project(surface.points.row(i).transpose()));
    Index covered = 0, differ = 0;
    for (int v = 0; v < mask.height; ++v)
      for (int u = 0; u < mask.width; ++u) {
        bool inside = false;
        for (Index t = 0; t < surface.triangles.rows() && !inside; ++t)
          inside = Inside(Vec2(u, v), pixel[surface.triangles(t, 0)],
                          pixel[surface.triangles(t, 1)], pixel[surface.triangles(t, 2)]);
        covered += inside;
        differ += inside != (mask.data[std::size_t(v) * mask.width + u] == 255);
      }
    EXPECT_GT(covered, 200) << away;
    EXPECT_EQ(differ, 0) << away;
  }
}

struct Echo : OrganSegmenter {
  int calls = 0;
  Image Segment(const Frame& frame, const Image& model_mask) override {
    ++calls;
    if (frame.index < 0) throw std::runtime_error("no frame");
    return model_mask;
  }
};

TEST(OrganSearch, FindsWhatTheLastBeginAskedFor) {
  const CameraModel camera = SomeCamera();
  const TetMesh mesh = testing::EllipsoidMesh({51.0, 27.5, 13.5}, 2);
  const SurfaceMesh here = BoundarySurface(mesh, mesh.rest);
  SurfaceMesh there = here;
  there.points.rowwise() += Eigen::RowVector3d(15, 0, 0);
  Echo echo;
  Frame frame;
  frame.index = 0;
  {
    OrganSearch search(echo, frame, camera);
    search.Begin(here);
    search.Begin(there);
    const Image expected = ProjectedMask(there, camera);
    EXPECT_EQ(search.Wait().model.data, expected.data);
    EXPECT_EQ(search.Wait().organ.data, expected.data);
    search.Begin(here);  // nobody waits for it
  }
  frame.index = -1;
  OrganSearch search(echo, frame, camera);
  search.Begin(here);
  EXPECT_THROW(search.Wait(), std::runtime_error);
}

}  // namespace
}  // namespace kerf
