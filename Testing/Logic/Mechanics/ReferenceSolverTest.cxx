#include <gtest/gtest.h>

#include "Core/Errors.h"
#include "Mechanics/ExactSolver.h"
#include "SpringScene.h"

namespace kerf {
namespace {

using testing::Kidney;
using testing::LargestDistance;
using testing::SoftTissue;
using testing::SurfaceSprings;

TEST(ReferenceSolver, RepeatedStepsReachTheMinimizerOfEquation5) {
  const TetMesh mesh = Kidney(4);
  Springs springs = SurfaceSprings(mesh, 100, 1e4);
  testing::MoveTargets(mesh, 0.3, &springs);
  Points exact = mesh.rest, stepped = mesh.rest, velocities;
  SolveOptions tight;
  tight.tolerance = 1e-12;
  auto yardstick = MakeExactSolver();
  yardstick->Reset(mesh, SoftTissue());
  ASSERT_TRUE(yardstick->Solve(springs, {}, tight, &exact, nullptr).converged);
  auto reference = MakeReferenceSolver();
  reference->Reset(mesh, SoftTissue());
  SolveOptions options;
  options.steps = 60;
  const SolveReport report = reference->Solve(springs, {}, options, &stepped, &velocities);
  EXPECT_TRUE(report.converged);
  EXPECT_LT(LargestDistance(exact, stepped), 0.05);
  EXPECT_EQ(velocities.rows(), mesh.VertexCount());
}

TEST(ReferenceSolver, RestIsARestAndReportsNoEnergy) {
  const TetMesh mesh = Kidney(3);
  auto reference = MakeReferenceSolver();
  reference->Reset(mesh, SoftTissue());
  Points positions = mesh.rest, velocities = Points::Zero(mesh.VertexCount(), 3);
  const SolveReport report =
      reference->Solve(SurfaceSprings(mesh, 50, 1e4), {}, {}, &positions, &velocities);
  EXPECT_LT(LargestDistance(positions, mesh.rest), 1e-9);
  EXPECT_LT(report.elastic_energy_uJ + report.spring_energy_uJ, 1e-9);
}

TEST(ReferenceSolver, SameBitsForOneAndTwoThreads) {
  const TetMesh mesh = Kidney(5);
  Springs springs = SurfaceSprings(mesh, 100, 1e4);
  testing::MoveTargets(mesh, 0.5, &springs);
  Points result[2];
  for (int threads : {1, 2}) {
    auto reference = MakeReferenceSolver();
    reference->Reset(mesh, SoftTissue());
    result[threads - 1] = mesh.rest;
    Points velocities;
    SolveOptions options;
    options.threads = threads;
    options.steps = 3;
    reference->Solve(springs, {}, options, &result[threads - 1], &velocities);
  }
  EXPECT_EQ(result[0], result[1]);
}

TEST(ReferenceSolver, WrongUseIsNamed) {
  const TetMesh mesh = Kidney(2);
  auto reference = MakeReferenceSolver();
  Material material = SoftTissue();
  material.poisson = 0.5;
  EXPECT_THROW(reference->Reset(mesh, material), UsageError);
  reference->Reset(mesh, SoftTissue());
  Points positions = mesh.rest;
  Springs springs = SurfaceSprings(mesh, 5, 1e4);
  springs.at.tet[3] = mesh.TetCount();
  EXPECT_THROW(reference->Solve(springs, {}, {}, &positions, nullptr), UsageError);
  springs.at.tet[3] = 0;
  springs.stiffness[2] = -1.0;
  EXPECT_THROW(reference->Solve(springs, {}, {}, &positions, nullptr), UsageError);
  Fixations fixations;
  fixations.vertices = {mesh.VertexCount()};
  fixations.targets = Points::Zero(1, 3);
  springs.stiffness[2] = 1.0;
  EXPECT_THROW(reference->Solve(springs, fixations, {}, &positions, nullptr), UsageError);
}

}  // namespace
}  // namespace kerf
