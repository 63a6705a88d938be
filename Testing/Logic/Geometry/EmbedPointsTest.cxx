#include <gtest/gtest.h>

#include <random>

#include "Geometry/EmbedPoints.h"
#include "Support/TestMeshes.h"

using namespace kerf;

namespace {

Points RandomPoints(int n, double low, double high, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> u(low, high);
  Points points(n, 3);
  for (int i = 0; i < n; ++i) points.row(i) << u(random), u(random), u(random);
  return points;
}

}  // namespace

TEST(EmbedPoints, ReproducesRestPositionsAndCountsInside) {
  const TetMesh mesh = kerf::testing::BoxMesh({12, 12, 12}, 5, 4, 3);
  Points points = RandomPoints(300, -5.99, 5.99, 1);
  EmbeddingReport report;
  const Embedding embedding = EmbedPoints(mesh, points, &report);
  EXPECT_EQ(report.inside, 300);
  EXPECT_EQ(report.outside, 0);
  EXPECT_LT((embedding.Positions(mesh.rest, mesh.tets) - points).cwiseAbs().maxCoeff(), 1e-11);
  EXPECT_GE(embedding.weights.minCoeff(), -1e-9);
}

TEST(EmbedPoints, IsExactForAffineMapsInsideAndOutside) {
  const TetMesh mesh = kerf::testing::BoxMesh({6, 6, 6}, 4, 4, 4);
  const Points points = RandomPoints(400, -4.0, 4.0, 2);
  EmbeddingReport report;
  const Embedding embedding = EmbedPoints(mesh, points, &report);
  EXPECT_GT(report.outside, 0);
  EXPECT_GT(report.inside, 0);
  EXPECT_EQ(report.inside + report.outside, 400);
  Mat3 a;
  a << 1.2, 0.3, -0.1, 0.0, 0.8, 0.2, 0.4, -0.2, 1.1;
  const Eigen::RowVector3d b(3, -7, 11);
  const Points moved = (mesh.rest * a.transpose()).rowwise() + b;
  const Points expected = (points * a.transpose()).rowwise() + b;
  EXPECT_LT((embedding.Positions(moved, mesh.tets) - expected).cwiseAbs().maxCoeff(), 1e-10);
}

TEST(EmbedPoints, OutsidePointsAreBoundToTheNearestTetrahedron) {
  const TetMesh mesh = kerf::testing::BoxMesh({4, 4, 4}, 4, 4, 4);
  Points points(3, 3);
  points << 0.2, 0.1, 2.5, -2.25, -0.7, -0.6, 0.2, 0.3, 0.4;
  EmbeddingReport report;
  const Embedding embedding = EmbedPoints(mesh, points, &report);
  EXPECT_EQ(report.outside, 2);
  EXPECT_NEAR(report.largest_distance_mm, 0.5, 1e-12);
  // The tetrahedron behind the nearest face contains the foot of the point.
  Points foot(1, 3);
  foot << 0.2, 0.1, 2.0;
  const auto c = mesh.tets.row(embedding.tet[0]);
  const Vec4 w = BarycentricWeights(
      foot.row(0).transpose(), mesh.rest.row(c[0]).transpose(), mesh.rest.row(c[1]).transpose(),
      mesh.rest.row(c[2]).transpose(), mesh.rest.row(c[3]).transpose());
  EXPECT_GE(w.minCoeff(), -1e-12);
}

TEST(EmbedPoints, VerticesAndFacesAreInside) {
  const TetMesh mesh = kerf::testing::BoxMesh({2.1, 2.1, 2.1}, 3, 3, 3);
  EmbeddingReport report;
  EmbedPoints(mesh, mesh.rest, &report);
  EXPECT_EQ(report.outside, 0);
}

TEST(EmbedPoints, ThinBandAndFarPoints) {
  const TetMesh mesh = kerf::testing::BandMesh();
  Points far(1, 3);
  far << 1000, -500, 300;
  EmbeddingReport report;
  const Embedding embedding = EmbedPoints(mesh, far, &report);
  EXPECT_EQ(report.outside, 1);
  EXPECT_LT((embedding.Positions(mesh.rest, mesh.tets) - far).norm(), 1e-8);
}

TEST(EmbedPoints, RefusesAnEmptyMesh) {
  EXPECT_THROW(EmbedPoints(TetMesh{}, Points::Zero(1, 3)), std::invalid_argument);
}
