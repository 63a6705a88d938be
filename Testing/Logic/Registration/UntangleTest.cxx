#include <gtest/gtest.h>

#include <random>

#include "Registration/Untangle.h"
#include "Support/TestMeshes.h"

namespace kerf {
namespace {

TEST(Untangle, LeavesAHealthyMeshAlone) {
  const TetMesh mesh = testing::BoxMesh(Vec3(20, 15, 15), 4, 3, 3);
  Points positions = mesh.rest * 1.2;
  const Points before = positions;
  EXPECT_EQ(Untangle(mesh, &positions), 0);
  EXPECT_EQ(positions, before);
}

TEST(Untangle, MakesInvertedElementsPositiveAndMovesOnlyTheirNeighbourhood) {
  const TetMesh mesh = testing::BoxMesh(Vec3(24, 20, 20), 6, 5, 5);
  Points positions = mesh.rest;
  const Index vertex = mesh.VertexCount() / 2;
  positions.row(vertex) += Eigen::RowVector3d(7.0, 2.0, -1.0);  // through its neighbours
  ASSERT_GT(MeasureQuality(mesh, positions).inverted, 0);
  EXPECT_GT(Untangle(mesh, &positions), 0);
  const MeshQuality quality = MeasureQuality(mesh, positions);
  EXPECT_EQ(quality.inverted, 0);
  EXPECT_GE(quality.smallest_dihedral_deg, 0.5);
  for (Index v = 0; v < mesh.VertexCount(); ++v) {
    const bool far = (mesh.rest.row(v) - mesh.rest.row(vertex)).norm() > 16.0;
    EXPECT_TRUE(!far || positions.row(v) == mesh.rest.row(v)) << v;
  }
}

// What is to be looked at again is known without looking at the whole mesh in each round.
TEST(Untangle, RoundByRoundItIsTheSame) {
  const TetMesh mesh = testing::BoxMesh(Vec3(24, 20, 20), 6, 5, 5);
  std::mt19937 random(5);
  std::normal_distribution<double> jitter(0.0, 4.0);
  Points crushed = mesh.rest;
  for (Index v = 0; v < mesh.VertexCount(); ++v)
    for (int k = 0; k < 3; ++k) crushed(v, k) += jitter(random);
  ASSERT_GT(MeasureQuality(mesh, crushed).inverted, 50);
  Points at_once = crushed, in_rounds = crushed;
  constexpr int kRounds = 30;
  int rounds = 0;
  Untangle(mesh, &at_once, 1.0, kRounds);
  while (rounds < kRounds && Untangle(mesh, &in_rounds, 1.0, 1) > 0) ++rounds;
  EXPECT_GT(rounds, 5);
  EXPECT_EQ(at_once, in_rounds);
}

}  // namespace
}  // namespace kerf
