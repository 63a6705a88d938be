#include <gtest/gtest.h>

#include <map>

#include "Cutting/CutStructure.h"
#include "Cutting/ExtrudePolyline.h"
#include "Cutting/SurfaceIndex.h"
#include "Cutting/TetCutter.h"
#include "Geometry/EmbedPoints.h"
#include "Support/TestMeshes.h"

namespace kerf::testing {
namespace {

struct Scene {
  TetMesh mesh = EllipsoidMesh({55, 35, 25}, 6);
  Structure tumour{"tumour", SphereSurface({2, 3, 1}, 9, 3), {}};
  Structure tube{"internal", TubeSurface({-30, 5, 2}, {30, -4, -3}, 3, 16, 40), {}};
  TetCutter cutter;
  CutReport report;

  Scene() {
    tumour.embedding = EmbedPoints(mesh, tumour.rest.points);
    tube.embedding = EmbedPoints(mesh, tube.rest.points);
  }
  static CutSurface UpTo(double y_end, double bend) {
    const int n = std::max(2, int((y_end + 45) / 4.5) + 1);
    Points line(n, 3), down(1, 3);
    for (int i = 0; i < n; ++i) {
      const double y = -45 + 4.5 * i;
      line.row(i) << 1 + bend * std::sin(0.06 * y), y, 26;
    }
    down << 0.1, 0, -1;
    return ExtrudePolyline(line, down, 10, 70, 2.5);
  }
  void Cut(double y_end, double bend, StructureCutMode mode) {
    const CutSurface s = UpTo(y_end, bend);
    const TopologyChange change = cutter.Cut(mesh, s, &report);
    for (Structure* structure : {&tumour, &tube}) {
      *structure = CutStructureSurface(*structure, s, change, mesh, mode);
      const Points at = structure->embedding.Positions(change.mesh.rest, change.mesh.tets);
      EXPECT_LT((at - structure->rest.points).cwiseAbs().maxCoeff(), 1e-9);
    }
    mesh = change.mesh;
  }
  /// Longest edge after the pieces of the organ were moved 100 mm apart.
  double LongestEdgeApart(const Structure& structure) const {
    std::vector<Index> component;
    TetComponents(mesh.tets, &component);
    Points positions = mesh.rest;
    for (Index t = 0; t < mesh.TetCount(); ++t)
      for (int k = 0; k < 4; ++k)
        positions(mesh.tets(t, k), 0) = mesh.rest(mesh.tets(t, k), 0) + 100 * component[t];
    const Points p = structure.embedding.Positions(positions, mesh.tets);
    double longest = 0;
    for (Index t = 0; t < structure.rest.triangles.rows(); ++t)
      for (int k = 0; k < 3; ++k)
        longest = std::max(longest, (p.row(structure.rest.triangles(t, k)) -
                                     p.row(structure.rest.triangles(t, (k + 1) % 3)))
                                        .norm());
    return longest;
  }
};

/// Edges with one triangle.
int RimEdges(const SurfaceMesh& surface) {
  std::map<std::pair<Index, Index>, int> count;
  for (Index t = 0; t < surface.triangles.rows(); ++t)
    for (int k = 0; k < 3; ++k) {
      const Index a = surface.triangles(t, k), b = surface.triangles(t, (k + 1) % 3);
      ++count[{std::min(a, b), std::max(a, b)}];
    }
  int rim = 0;
  for (const auto& [edge, n] : count) rim += n == 1;
  return rim;
}

class CutStructures : public ::testing::TestWithParam<double> {};

TEST_P(CutStructures, SplitAlongSAndPartWithTheOrgan) {
  Scene scene;
  const double whole = scene.tumour.rest.SignedVolume(), area = scene.tumour.rest.Area();
  for (double y = -30; y <= 45; y += 9) scene.Cut(y, GetParam(), StructureCutMode::Split);
  ASSERT_EQ(scene.report.components, 2);
  EXPECT_EQ(scene.tumour.rest.Components(), 2);
  EXPECT_EQ(scene.tube.rest.Components(), 2);
  EXPECT_NEAR(scene.tumour.rest.Area(), area, 1e-9 * area);  // nothing deleted
  const auto pieces = PieceVolumes_mm3(scene.tumour.rest);
  ASSERT_EQ(pieces.size(), 2u);
  EXPECT_NEAR(pieces[0] + pieces[1], whole, 1e-6 * whole);
  EXPECT_GT(std::min(pieces[0], pieces[1]), 0.2 * whole);
  EXPECT_GT(RimEdges(scene.tumour.rest), 0);
  // Every point parts with the piece its triangles lie in: no triangle spans the gap.
  EXPECT_LT(scene.LongestEdgeApart(scene.tumour), 3);
  EXPECT_LT(scene.LongestEdgeApart(scene.tube), 4);
  // Rim points lie on S.
  const SurfaceIndex index(Scene::UpTo(60, GetParam()));
  const Index old_points = SphereSurface({2, 3, 1}, 9, 3).points.rows();
  for (Index i = old_points; i < scene.tumour.rest.points.rows(); ++i)
    EXPECT_LT(index.Closest(scene.tumour.rest.points.row(i).transpose(), 10).distance_mm, 1e-9);
}

TEST_P(CutStructures, Equation12DeletesWhatMeetsS) {
  Scene scene;
  const Index before = scene.tumour.rest.triangles.rows();
  for (double y = -30; y <= 45; y += 9) scene.Cut(y, GetParam(), StructureCutMode::DeleteTriangles);
  EXPECT_LT(scene.tumour.rest.triangles.rows(), before);
  EXPECT_GT(scene.tumour.rest.triangles.rows(), 0.8 * before);
  EXPECT_EQ(scene.tumour.rest.Components(), 2);
  EXPECT_LT(scene.LongestEdgeApart(scene.tumour), 3);
}

INSTANTIATE_TEST_SUITE_P(PlaneAndCurved, CutStructures, ::testing::Values(0.0, 8.0));

TEST(CutStructure, WhereTheOrganStaysClosedTheStructureDoesToo) {
  Scene scene;
  const Index triangles = scene.tube.rest.triangles.rows();
  scene.Cut(-20, 0, StructureCutMode::Split);  // ends before the tube
  ASSERT_TRUE(scene.report.done);
  EXPECT_EQ(scene.tube.rest.triangles.rows(), triangles);
  EXPECT_TRUE(scene.tube.rest.IsClosedManifold());
}

TEST(CutStructure, ClosedSurfaceHasOnePieceOfItsVolume) {
  const SurfaceMesh sphere = SphereSurface({1, 2, 3}, 5, 2);
  const auto pieces = PieceVolumes_mm3(sphere);
  ASSERT_EQ(pieces.size(), 1u);
  EXPECT_NEAR(pieces[0], sphere.SignedVolume(), 1e-9);
}

}  // namespace
}  // namespace kerf::testing
