#include <gtest/gtest.h>

#include "LabelShapes.h"
#include "Meshing/ImproveDihedral.h"
#include "Meshing/TetMesher.h"
#include "Support/TestMeshes.h"

using namespace kerf;
using kerf::testing::RecordedProgress;

namespace {

SurfaceMesh Band() {
  const TetMesh mesh = kerf::testing::BoxMesh({120, 30, 4}, 12, 4, 1);
  return BoundarySurface(mesh, mesh.rest);
}

MeshingOptions Wanted(int tetrahedra) {
  MeshingOptions options;
  options.tetrahedra = tetrahedra;
  return options;
}

/// The element that a refused surface is blamed on.
std::string Blamed(const SurfaceMesh& surface) {
  RecordedProgress progress;
  try {
    MeshClosedSurface(surface, "band.stl", Wanted(1000), progress);
  } catch (const InputError& error) {
    EXPECT_EQ(error.File(), "band.stl");
    return error.what();
  }
  return "accepted";
}

}  // namespace

TEST(MeshClosedSurface, KeepsTheSharpEdgesOfAThinBand) {
  RecordedProgress progress;
  MeshingReport report;
  const TetMesh mesh = MeshClosedSurface(Band(), "band.stl", Wanted(8000), progress, &report);
  EXPECT_NEAR(mesh.TetCount(), 8000, 1200);
  EXPECT_NEAR(report.quality.volume_mm3, 120 * 30 * 4, 1e-3 * 14400);
  EXPECT_GE(report.quality.smallest_dihedral_deg, 8.0);
  EXPECT_TRUE(report.quality.manifold_boundary);
  EXPECT_NEAR(mesh.rest.col(2).maxCoeff(), 2.0, 1e-9);
  EXPECT_NEAR(mesh.rest.col(0).minCoeff(), -60.0, 1e-9);
}

TEST(MeshClosedSurface, SphereTwiceTheSame) {
  const SurfaceMesh sphere = kerf::testing::SphereSurface({5, 6, 7}, 20, 3);
  RecordedProgress progress;
  MeshingReport report;
  const TetMesh a = MeshClosedSurface(sphere, "s", Wanted(2500), progress, &report);
  const TetMesh b = MeshClosedSurface(sphere, "s", Wanted(2500), progress);
  EXPECT_NEAR(a.TetCount(), 2500, 375);
  EXPECT_NEAR(report.quality.volume_mm3 / sphere.SignedVolume(), 1.0, 0.02);
  EXPECT_GE(report.quality.smallest_dihedral_deg, 8.0);
  ASSERT_EQ(a.TetCount(), b.TetCount());
  EXPECT_TRUE((a.rest.array() == b.rest.array()).all());
}

TEST(MeshClosedSurface, RefusesAnInvertedSurface) {
  SurfaceMesh band = Band();
  band.triangles.col(1).swap(band.triangles.col(2));
  EXPECT_NE(Blamed(band).find("inverted"), std::string::npos);
}

TEST(MeshClosedSurface, RefusesAHoleNamingTheTriangle) {
  SurfaceMesh band = Band();
  band.triangles.conservativeResize(band.triangles.rows() - 1, 3);
  EXPECT_NE(Blamed(band).find("not closed"), std::string::npos);
  EXPECT_NE(Blamed(band).find("triangle"), std::string::npos);
}

TEST(MeshClosedSurface, RefusesOneFlippedTriangle) {
  SurfaceMesh band = Band();
  std::swap(band.triangles(5, 1), band.triangles(5, 2));
  EXPECT_NE(Blamed(band).find("oriented against"), std::string::npos);
}

TEST(MeshClosedSurface, RefusesSelfIntersections) {
  SurfaceMesh sphere = kerf::testing::SphereSurface({0, 0, 0}, 20, 2);
  sphere.points.row(0) *= -1.4;  // a spike through the other side
  EXPECT_NE(Blamed(sphere).find("intersects itself"), std::string::npos);
}

TEST(MeshClosedSurface, RefusesNanBadIndicesAndNothing) {
  SurfaceMesh band = Band();
  band.points(3, 1) = std::nan("");
  EXPECT_NE(Blamed(band).find("point 3"), std::string::npos);
  band = Band();
  band.triangles(7, 0) = 100000;
  EXPECT_NE(Blamed(band).find("triangle 7"), std::string::npos);
  EXPECT_NE(Blamed(SurfaceMesh{}).find("triangles"), std::string::npos);
}

TEST(ImproveDihedral, RaisesTheWorstAngleAndHoldsTheBoundary) {
  TetMesh mesh = kerf::testing::Jitter(kerf::testing::BoxMesh({10, 10, 10}, 5, 5, 5), 0.6, 1.0, 3);
  const MeshQuality before = MeasureQuality(mesh, mesh.rest);
  const Points start = mesh.rest;
  DihedralOptions options;
  options.wanted_deg = 12.0;
  const double smallest = ImproveDihedral(options, &mesh);
  const MeshQuality after = MeasureQuality(mesh, mesh.rest);
  ASSERT_LT(before.smallest_dihedral_deg, 8.0);
  EXPECT_GE(after.smallest_dihedral_deg, 12.0);
  EXPECT_DOUBLE_EQ(after.smallest_dihedral_deg, smallest);
  EXPECT_NEAR(after.volume_mm3, before.volume_mm3, 1e-9 * before.volume_mm3);
  EXPECT_EQ(after.inverted, 0);
  const Triangles boundary = BoundaryFaces(mesh.tets);
  for (Index f = 0; f < boundary.rows(); ++f)
    EXPECT_EQ(mesh.rest.row(boundary(f, 0)), start.row(boundary(f, 0)));
}
