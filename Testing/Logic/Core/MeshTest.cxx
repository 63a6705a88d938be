#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>

#include "Core/Embedding.h"
#include "Core/Errors.h"
#include "Core/SurfaceMesh.h"
#include "Core/TetMesh.h"
#include "Support/TestMeshes.h"

namespace kerf {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

/// Regular tetrahedron with edge √2·2: every dihedral angle is arccos(1/3).
TetMesh RegularTet() {
  TetMesh mesh;
  mesh.rest.resize(4, 3);
  mesh.rest << 1, 1, 1, -1, -1, 1, -1, 1, -1, 1, -1, -1;
  mesh.tets.resize(1, 4);
  mesh.tets << 0, 1, 2, 3;
  if (TetVolume(mesh.rest, mesh.tets, 0) < 0) mesh.tets << 0, 2, 1, 3;
  mesh.region = {1};
  return mesh;
}

template <typename Mesh>
std::string MessageOf(const Mesh& mesh) {
  try {
    mesh.Validate("mesh.vtu");
  } catch (const InputError& e) {
    return e.what();
  }
  return {};
}

TEST(TetMesh, QualityOfARegularTetrahedron) {
  const TetMesh mesh = RegularTet();
  const MeshQuality q = MeasureQuality(mesh, mesh.rest);
  EXPECT_NEAR(q.smallest_dihedral_deg, std::acos(1.0 / 3.0) * 180 / M_PI, 1e-9);
  EXPECT_NEAR(q.volume_mm3, 8.0 / 3.0, 1e-12);
  EXPECT_EQ(q.components, 1);
  EXPECT_EQ(q.inverted, 0);
  EXPECT_EQ(q.orphans, 0);
  EXPECT_TRUE(q.manifold_boundary);
}

TEST(TetMesh, QualitySeesInvertedElementsAndOrphans) {
  TetMesh mesh = RegularTet();
  Points positions = mesh.rest;
  positions.row(3) *= -3.0;  // through the opposite face
  EXPECT_EQ(MeasureQuality(mesh, positions).inverted, 1);
  EXPECT_LT(MeasureQuality(mesh, positions).smallest_dihedral_deg, 0.0);
  mesh.rest.conservativeResize(5, 3);
  mesh.rest.row(4).setZero();
  EXPECT_EQ(MeasureQuality(mesh, mesh.rest).orphans, 1);
}

TEST(TetMesh, QualityOfACornerTetrahedron) {
  // Three right angles at the corner, arccos(1/√3) at the others.
  EXPECT_NEAR(SmallestDihedral_deg({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}),
              std::acos(1 / std::sqrt(3.0)) * 180 / M_PI, 1e-9);
  EXPECT_EQ(SmallestDihedral_deg({0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 0, 1}), 0.0);
}

TEST(TetMesh, TwoTetrahedraThatShareAnEdgeAreNoManifold) {
  TetMesh mesh;
  mesh.rest.resize(6, 3);
  mesh.rest << 0, 0, 0, 0, 0, 1, 1, 0, 0, 1, 1, 0, -1, 0, 0, -1, -1, 0;
  mesh.tets.resize(2, 4);
  mesh.tets << 0, 2, 3, 1, 0, 4, 5, 1;
  mesh.region = {1, 1};
  ASSERT_EQ(MessageOf(mesh), "");
  const MeshQuality q = MeasureQuality(mesh, mesh.rest);
  EXPECT_EQ(q.components, 2) << "components are connected through faces";
  EXPECT_FALSE(q.manifold_boundary);
}

TEST(TetMesh, BoundaryOfABoxIsClosedAndHoldsItsVolume) {
  const TetMesh mesh = testing::BoxMesh({30, 20, 10}, 6, 4, 2);
  std::vector<Index> tet_of_face, vertex;
  const Triangles faces = BoundaryFaces(mesh.tets, &tet_of_face);
  EXPECT_EQ(faces.rows(), 2 * 2 * (6 * 4 + 4 * 2 + 6 * 2));
  EXPECT_EQ(tet_of_face.size(), static_cast<std::size_t>(faces.rows()));
  const SurfaceMesh surface = BoundarySurface(mesh, mesh.rest, &vertex);
  EXPECT_TRUE(surface.IsClosedManifold());
  EXPECT_NEAR(surface.SignedVolume(), 6000.0, 1e-6) << "positive: oriented outwards";
  EXPECT_NEAR(surface.Area(), 2 * (600 + 200 + 300), 1e-6);
  EXPECT_NEAR(MeasureQuality(mesh, mesh.rest).volume_mm3, 6000.0, 1e-6);
  for (Index i = 0; i < surface.points.rows(); ++i)
    EXPECT_EQ(surface.points.row(i), mesh.rest.row(vertex[i]));
}

// Around a hub that all tetrahedra share: many faces have the same smallest vertex.
TEST(TetMesh, BoundaryFacesAreThoseOfOneTetrahedron) {
  const SurfaceMesh ball = testing::SphereSurface({0, 0, 0}, 20, 2);
  Tets tets(ball.triangles.rows() + 2, 4);
  for (Index t = 0; t < ball.triangles.rows(); ++t)
    tets.row(t) << 0, (ball.triangles.row(t).array() + 1).matrix();
  // One outer face has two tetrahedra more: of three it is nobody's boundary.
  const Index n = static_cast<Index>(ball.points.rows());
  tets.bottomRows(2) << tets(5, 1), tets(5, 3), tets(5, 2), n + 1, tets(5, 1), tets(5, 3),
      tets(5, 2), n + 2;
  std::vector<Index> tet_of_face;
  const Triangles faces = BoundaryFaces(tets, &tet_of_face);
  ASSERT_EQ(faces.rows(), ball.triangles.rows() - 1 + 2 * 3);
  for (Index i = 0; i < faces.rows(); ++i) {
    int owners = 0;
    for (Index t = 0; t < tets.rows(); ++t) {
      int shared = 0;
      for (int k = 0; k < 4; ++k) shared += (faces.row(i).array() == tets(t, k)).any();
      owners += shared == 3;
    }
    EXPECT_EQ(owners, 1);
    if (i > 0) {
      EXPECT_LE(tet_of_face[i - 1], tet_of_face[i]);
    }
  }
}

TEST(TetMesh, ValidationNamesTheElement) {
  TetMesh mesh = RegularTet();
  mesh.region.clear();
  EXPECT_THAT(MessageOf(mesh), HasSubstr("region"));
  mesh = RegularTet();
  mesh.tets(0, 2) = 9;
  EXPECT_THAT(MessageOf(mesh), AllOf(HasSubstr("tetrahedron 0"), HasSubstr("9")));
  mesh = RegularTet();
  std::swap(mesh.tets(0, 0), mesh.tets(0, 1));
  EXPECT_THAT(MessageOf(mesh), HasSubstr("inverted"));
  mesh = RegularTet();
  mesh.rest(2, 1) = std::numeric_limits<double>::infinity();
  EXPECT_THAT(MessageOf(mesh), HasSubstr("vertex 2"));
}

TEST(SurfaceMesh, OpenAndTurnedSurfacesAreNotClosed) {
  SurfaceMesh sphere = testing::SphereSurface(Vec3(1, 2, 3), 10, 4);
  EXPECT_TRUE(sphere.IsClosedManifold());
  EXPECT_NEAR(sphere.SignedVolume(), 4.0 / 3.0 * M_PI * 1000, 20);
  SurfaceMesh open = sphere;
  open.triangles.conservativeResize(open.triangles.rows() - 1, 3);
  EXPECT_FALSE(open.IsClosedManifold());
  SurfaceMesh turned = sphere;
  std::swap(turned.triangles(5, 0), turned.triangles(5, 1));
  EXPECT_FALSE(turned.IsClosedManifold());
  SurfaceMesh inverted = sphere;
  inverted.triangles.col(0).swap(inverted.triangles.col(1));
  EXPECT_TRUE(inverted.IsClosedManifold());
  EXPECT_LT(inverted.SignedVolume(), 0.0);
  EXPECT_FALSE(SurfaceMesh().IsClosedManifold());
}

TEST(SurfaceMesh, ComponentsAreConnectedThroughEdges) {
  const SurfaceMesh a = testing::SphereSurface(Vec3(0, 0, 0), 5, 1);
  const SurfaceMesh b = testing::SphereSurface(Vec3(30, 0, 0), 5, 1);
  SurfaceMesh both;
  both.points.resize(a.points.rows() + b.points.rows(), 3);
  both.points << a.points, b.points;
  both.triangles.resize(a.triangles.rows() + b.triangles.rows(), 3);
  both.triangles << a.triangles,
      (b.triangles.array() + static_cast<Index>(a.points.rows())).matrix();
  std::vector<Index> component;
  EXPECT_EQ(both.Components(&component), 2);
  EXPECT_EQ(component.front(), 0);
  EXPECT_EQ(component.back(), 1);
  EXPECT_EQ(a.Components(), 1);

  // Two triangles that meet in a point are two components.
  SurfaceMesh corner;
  corner.points.resize(5, 3);
  corner.points << 0, 0, 0, 1, 0, 0, 0, 1, 0, -1, 0, 0, 0, -1, 0;
  corner.triangles.resize(2, 3);
  corner.triangles << 0, 1, 2, 0, 3, 4;
  EXPECT_EQ(corner.Components(), 2);
}

TEST(SurfaceMesh, ValidationNamesTheElement) {
  SurfaceMesh s = testing::SphereSurface(Vec3::Zero(), 5, 0);
  EXPECT_EQ(MessageOf(s), "");
  s.triangles(3, 1) = -1;
  EXPECT_THAT(MessageOf(s), HasSubstr("triangle 3"));
  s = testing::SphereSurface(Vec3::Zero(), 5, 0);
  s.points(7, 0) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(MessageOf(s), HasSubstr("point 7"));
}

TEST(Embedding, ReproducesAffineMaps) {
  const TetMesh mesh = testing::BoxMesh({10, 10, 10}, 2, 2, 2);
  Embedding embedding;
  const Index n = mesh.TetCount();
  embedding.weights.resize(n, 4);
  Points rest(n, 3);
  for (Index t = 0; t < n; ++t) {
    embedding.tet.push_back(t);
    // Also outside of the tetrahedron: weights extrapolate.
    embedding.weights.row(t) << 0.5, 0.4 + 0.01 * (t % 7), -0.1, 0.2 - 0.01 * (t % 7);
  }
  rest = embedding.Positions(mesh.rest, mesh.tets);
  Mat3 a;
  a << 1.3, 0.2, 0, -0.1, 0.8, 0.3, 0.2, 0, 1.2;
  const Vec3 b(3, -4, 5);
  Points moved = mesh.rest * a.transpose();
  moved.rowwise() += b.transpose();
  Points expected = rest * a.transpose();
  expected.rowwise() += b.transpose();
  Points found;
  embedding.Positions(moved, mesh.tets, &found);
  EXPECT_LT((found - expected).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(Embedding, BarycentricWeightsRebuildThePoint) {
  const Vec3 a(0, 0, 0), b(3, 0, 1), c(0, 4, 0), d(1, 1, 5);
  for (const Vec3& p : {Vec3(1, 1, 1), Vec3(-5, 8, 2), a, Vec3(0.5 * (c + d))}) {
    const Vec4 w = BarycentricWeights(p, a, b, c, d);
    EXPECT_NEAR(w.sum(), 1.0, 1e-12);
    EXPECT_LT((w[0] * a + w[1] * b + w[2] * c + w[3] * d - p).norm(), 1e-12);
  }
  EXPECT_LT((BarycentricWeights(b, a, b, c, d) - Vec4(0, 1, 0, 0)).norm(), 1e-12);
}

}  // namespace
}  // namespace kerf
