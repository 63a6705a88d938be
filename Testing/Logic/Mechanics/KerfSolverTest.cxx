#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include "Core/Errors.h"
#include "Mechanics/ExactSolver.h"
#include "SpringScene.h"
#include "Support/Draws.h"
#include "VertexSplitting.h"

namespace kerf {
namespace {

using testing::Kidney;
using testing::LargestDistance;
using testing::MoveTargets;
using testing::SoftTissue;
using testing::SurfaceSprings;

Points Minimizer(const TetMesh& mesh, const Material& material, const Springs& springs,
                 const Fixations& fixations, const Points& start) {
  SolveOptions tight;
  tight.tolerance = 1e-10;
  auto exact = MakeExactSolver();
  exact->Reset(mesh, material);
  Points positions = start;
  EXPECT_TRUE(exact->Solve(springs, fixations, tight, &positions, nullptr).converged);
  return positions;
}

/// Two copies of a mesh, 200 mm apart along y, as one.
TetMesh Twins(const TetMesh& one) {
  TetMesh both = one;
  const Index n = one.VertexCount(), t = one.TetCount();
  both.rest.conservativeResize(2 * n, 3);
  both.rest.bottomRows(n) = one.rest.rowwise() + Eigen::RowVector3d(0, 200, 0);
  both.tets.conservativeResize(2 * t, 4);
  both.tets.bottomRows(t) = one.tets.array() + n;
  both.region.insert(both.region.end(), one.region.begin(), one.region.end());
  return both;
}

TEST(KerfSolver, FollowsAMovingTargetWithinTolerance) {
  const TetMesh mesh = testing::Jitter(Kidney(6), 0.2, 8.0, 1);
  Springs springs = SurfaceSprings(mesh, 225, 1e4);
  auto solver = MakeKerfSolver();
  solver->Reset(mesh, SoftTissue());
  Points positions = mesh.rest;
  for (int frame = 1; frame <= 30; ++frame) {
    MoveTargets(mesh, frame / 30.0, &springs);
    const SolveReport report = solver->Solve(springs, {}, {}, &positions, nullptr);
    EXPECT_TRUE(report.converged);
    EXPECT_LE(report.steps, 3);
    if (frame % 10 == 0) {
      EXPECT_LT(LargestDistance(positions, Minimizer(mesh, SoftTissue(), springs, {}, positions)),
                0.05);
    }
  }
}

TEST(KerfSolver, JumpsConvergeForSoftAndNearlyIncompressibleTissue) {
  const TetMesh mesh = Kidney(5);
  for (double poisson : {0.0, 0.3, 0.45, 0.49}) {
    Springs springs = SurfaceSprings(mesh, 150, 1e4);
    MoveTargets(mesh, 1.0, &springs);
    auto solver = MakeKerfSolver();
    solver->Reset(mesh, SoftTissue(poisson));
    Points positions = mesh.rest;
    const SolveReport report = solver->Solve(springs, {}, {}, &positions, nullptr);
    EXPECT_TRUE(report.converged) << poisson;
    EXPECT_LT(
        LargestDistance(positions, Minimizer(mesh, SoftTissue(poisson), springs, {}, positions)),
        0.05)
        << poisson;
  }
}

TEST(KerfSolver, EnergiesAreThoseOfTheYardstick) {
  const TetMesh mesh = Kidney(4);
  Springs springs = SurfaceSprings(mesh, 80, 1e4);
  MoveTargets(mesh, 1.0, &springs);
  Points positions = mesh.rest;
  SolveOptions tight;
  tight.tolerance = 1e-6;
  auto solver = MakeKerfSolver();
  solver->Reset(mesh, SoftTissue());
  const SolveReport report = solver->Solve(springs, {}, tight, &positions, nullptr);
  auto exact = MakeExactSolver();
  exact->Reset(mesh, SoftTissue());
  SolveOptions no_step = tight;
  no_step.tolerance = 1e9;  // energies at the given positions, to within one harmless step
  const SolveReport truth = exact->Solve(springs, {}, no_step, &positions, nullptr);
  EXPECT_NEAR(report.elastic_energy_uJ, truth.elastic_energy_uJ, 1e-3 * truth.elastic_energy_uJ);
  EXPECT_NEAR(report.spring_energy_uJ, truth.spring_energy_uJ, 1e-3 * truth.spring_energy_uJ);
}

TEST(KerfSolver, RestStaysAndRigidTargetsGiveARigidMotion) {
  const TetMesh mesh = Kidney(4);
  Springs springs = SurfaceSprings(mesh, 60, 1e4);
  auto solver = MakeKerfSolver();
  solver->Reset(mesh, SoftTissue());
  Points positions = mesh.rest;
  solver->Solve(springs, {}, {}, &positions, nullptr);
  EXPECT_LT(LargestDistance(positions, mesh.rest), 1e-3);
  const Mat3 turn = Eigen::AngleAxisd(2.0, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  const Points moved = (mesh.rest * turn.transpose()).rowwise() + Eigen::RowVector3d(40, -300, 12);
  springs.targets = springs.at.Positions(moved, mesh.tets);
  const SolveReport report = solver->Solve(springs, {}, {}, &positions, nullptr);
  EXPECT_LT(LargestDistance(positions, moved), 2e-3);
  EXPECT_LT(report.elastic_energy_uJ, 1e-3);
}

TEST(KerfSolver, RecoversFromInvertedFlatAndCrushedStarts) {
  const TetMesh mesh = Kidney(4);
  Springs springs = SurfaceSprings(mesh, 100, 1e4);
  MoveTargets(mesh, 0.3, &springs);
  const Points truth = Minimizer(mesh, SoftTissue(), springs, {}, mesh.rest);
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0.0, 4.0);
  for (int start = 0; start < 4; ++start) {
    Points positions = mesh.rest;
    if (start == 0) positions.col(2).setZero();
    if (start == 1) positions.col(2) *= -1.0;
    if (start == 2) positions.setZero();
    if (start == 3)
      for (Index i = 0; i < positions.size(); ++i) positions.data()[i] += noise(random);
    auto solver = MakeKerfSolver();
    solver->Reset(mesh, SoftTissue());
    bool converged = false;
    for (int call = 0; call < 20 && !converged; ++call)
      converged = solver->Solve(springs, {}, {}, &positions, nullptr).converged;
    EXPECT_TRUE(converged) << start;
    EXPECT_LT(LargestDistance(positions, truth), 0.1) << start;
  }
}

TEST(KerfSolver, AComponentWithoutSpringsKeepsItsShapeAndPlace) {
  const TetMesh mesh = Twins(Kidney(3));
  const Index n = mesh.VertexCount() / 2;
  Springs springs = SurfaceSprings(Kidney(3), 50, 1e4);  // at the first twin alone
  auto solver = MakeKerfSolver();
  solver->Reset(mesh, SoftTissue());
  Points positions = mesh.rest;
  for (int frame = 1; frame <= 20; ++frame) {
    for (Index l = 0; l < springs.at.Size(); ++l) springs.targets(l, 0) *= 1.005;
    EXPECT_TRUE(solver->Solve(springs, {}, {}, &positions, nullptr).converged);
  }
  EXPECT_GT(LargestDistance(positions.topRows(n), mesh.rest.topRows(n)), 1.0);
  EXPECT_LT(LargestDistance(positions.bottomRows(n), mesh.rest.bottomRows(n)), 1.0);
  // Its edges keep their lengths.
  for (Index t = mesh.TetCount() / 2; t < mesh.TetCount(); ++t) {
    const Index a = mesh.tets(t, 0), b = mesh.tets(t, 1);
    EXPECT_NEAR((positions.row(a) - positions.row(b)).norm(),
                (mesh.rest.row(a) - mesh.rest.row(b)).norm(), 1e-2);
  }
}

TEST(KerfSolver, NoSpringsAtAllIsAResult) {
  const TetMesh mesh = Kidney(3);
  auto solver = MakeKerfSolver();
  solver->Reset(mesh, SoftTissue());
  Points positions = mesh.rest;
  Springs none;
  none.targets.resize(0, 3);
  none.at.weights.resize(0, 4);
  const SolveReport report = solver->Solve(none, {}, {}, &positions, nullptr);
  EXPECT_TRUE(report.converged);
  EXPECT_LT(LargestDistance(positions, mesh.rest), 1e-3);
  // One spring: the body follows without turning wildly or stretching.
  Springs one = SurfaceSprings(mesh, 1, 1e4);
  one.targets.row(0) += Eigen::RowVector3d(3, 0, 2);
  for (int call = 0; call < 3; ++call) solver->Solve(one, {}, {}, &positions, nullptr);
  EXPECT_LT((one.at.Positions(positions, mesh.tets) - one.targets).norm(), 0.05);
}

TEST(KerfSolver, RobustWeightsTakeOutliersOut) {
  const TetMesh mesh = Kidney(4);
  Springs springs = SurfaceSprings(mesh, 120, 1e4);
  MoveTargets(mesh, 0.2, &springs);
  const Points truth = Minimizer(mesh, SoftTissue(), springs, {}, mesh.rest);
  for (Index l = 0; l < springs.at.Size(); l += 15)
    springs.targets.row(l) += Eigen::RowVector3d(0, 25, 10);
  auto error = [&](double scale, SolveReport* report) {
    springs.robust_scale_mm = scale;
    auto solver = MakeKerfSolver();
    solver->Reset(mesh, SoftTissue());
    Points positions = mesh.rest;
    for (int call = 0; call < 5; ++call)
      *report = solver->Solve(springs, {}, {}, &positions, nullptr);
    return LargestDistance(positions, truth);
  };
  SolveReport quadratic, robust;
  EXPECT_GT(error(0.0, &quadratic), 3.0);
  EXPECT_LT(error(3.0, &robust), 0.5);
  for (Index l = 0; l < springs.at.Size(); ++l) {
    EXPECT_EQ(quadratic.spring_weights[l], 1.0);
    if (l % 15 == 0)
      EXPECT_LT(robust.spring_weights[l], 0.1);
    else
      EXPECT_GT(robust.spring_weights[l], 0.8);
  }
}

TEST(KerfSolver, RaysIgnoreDepthAndHoldTheSides) {
  const TetMesh mesh = Kidney(4);
  Springs springs = SurfaceSprings(mesh, 120, 1e4);
  springs.directions = Points::Zero(springs.at.Size(), 3);
  springs.directions.col(2).setOnes();
  springs.along_factor = 0.0;
  springs.targets.rowwise() += Eigen::RowVector3d(4, 0, 50);  // the 50 mm are along the rays
  auto solver = MakeKerfSolver();
  solver->Reset(mesh, SoftTissue());
  Points positions = mesh.rest;
  EXPECT_TRUE(solver->Solve(springs, {}, {}, &positions, nullptr).converged);
  const Points expected = mesh.rest.rowwise() + Eigen::RowVector3d(4, 0, 0);
  EXPECT_LT(LargestDistance(positions, expected), 0.02);
}

TEST(KerfSolver, FixationsHoldAndAgreeWithTheYardstick) {
  const TetMesh mesh = Kidney(4);
  Springs springs = SurfaceSprings(mesh, 60, 1e4);
  MoveTargets(mesh, 0.5, &springs);
  Fixations fixations;
  for (Index v = 0; v < mesh.VertexCount(); ++v)
    if (mesh.rest(v, 0) < -38.0) fixations.vertices.push_back(v);
  fixations.targets.resize(static_cast<Index>(fixations.vertices.size()), 3);
  for (std::size_t i = 0; i < fixations.vertices.size(); ++i)
    fixations.targets.row(static_cast<Index>(i)) = mesh.rest.row(fixations.vertices[i]);
  fixations.stiffness_g_s2 = 1e6;
  auto solver = MakeKerfSolver();
  solver->Reset(mesh, SoftTissue());
  Points positions = mesh.rest;
  EXPECT_TRUE(solver->Solve(springs, fixations, {}, &positions, nullptr).converged);
  for (Index v : fixations.vertices) EXPECT_LT((positions.row(v) - mesh.rest.row(v)).norm(), 0.2);
  EXPECT_LT(
      LargestDistance(positions, Minimizer(mesh, SoftTissue(), springs, fixations, positions)),
      0.05);
}

TEST(KerfSolver, InertiaSlowsTheMotionAndReachesTheMinimizer) {
  const TetMesh mesh = Kidney(3);
  Springs springs = SurfaceSprings(mesh, 60, 1e2);
  MoveTargets(mesh, 1.0, &springs);
  auto solver = MakeKerfSolver();
  solver->Reset(mesh, SoftTissue());
  SolveOptions options;
  options.inertia = true;
  Points positions = mesh.rest, velocities = Points::Zero(mesh.VertexCount(), 3);
  solver->Solve(springs, {}, options, &positions, &velocities);
  const Points truth = Minimizer(mesh, SoftTissue(), springs, {}, mesh.rest);
  EXPECT_GT(LargestDistance(positions, truth), 1.0);
  EXPECT_GT(velocities.norm(), 1.0);
  for (int step = 0; step < 300; ++step) {
    velocities *= 0.9;
    solver->Solve(springs, {}, options, &positions, &velocities);
  }
  EXPECT_LT(LargestDistance(positions, truth), 0.3);
}

TEST(KerfSolver, SameBitsForEveryThreadCount) {
  const TetMesh mesh = Kidney(6);
  const auto run = [&](int threads) {
    Points positions = mesh.rest;
    Springs springs = SurfaceSprings(mesh, 150, 1e4);
    auto solver = MakeKerfSolver();
    solver->Reset(mesh, SoftTissue());
    SolveOptions options;
    options.threads = threads;
    for (int frame = 1; frame <= 5; ++frame) {
      MoveTargets(mesh, frame / 10.0, &springs);
      solver->Solve(springs, {}, options, &positions, nullptr);
    }
    return positions;
  };
  const Points one = run(1);
  EXPECT_EQ(one, run(2));
  EXPECT_EQ(one, run(4));
  for (int of_caller : {1, 3}) {  // 0: those that the caller works with
    tbb::task_arena arena(of_caller);
    EXPECT_EQ(one, arena.execute([&] { return run(0); }));
  }
}

TEST(KerfSolver, AGrowingCutIsFollowedInEveryFrame) {
  TetMesh mesh = testing::BoxMesh({80, 40, 20}, 16, 8, 4);
  Springs springs = SurfaceSprings(mesh, 100, 1e4);
  auto solver = MakeKerfSolver();
  solver->Reset(mesh, SoftTissue());
  Points positions = mesh.rest;
  for (int frame = 1; frame <= 9; ++frame) {
    // The plane x = 0 opens from y = −20 on, 5 mm a frame, in the end all of it.
    std::vector<Index> front;
    for (Index v = 0; v < mesh.VertexCount(); ++v)
      if (std::abs(mesh.rest(v, 0)) < 1e-9 &&
          std::abs(mesh.rest(v, 1) - (-25.0 + 5.0 * frame)) < 1e-9)
        front.push_back(v);
    const TopologyChange change = testing::OpenPlane(mesh, front, Vec3::UnitX(), 0.0);
    springs.at = change.MapEmbedding(springs.at, mesh);
    positions = change.MapVertexField(positions);
    mesh = change.mesh;
    solver->Apply(change);
    const Points rest = springs.at.Positions(mesh.rest, mesh.tets);
    springs.targets = rest;
    for (Index l = 0; l < rest.rows(); ++l)
      springs.targets(l, 0) += (rest(l, 0) > 0 ? 0.4 : -0.4) * frame;
    const SolveReport report = solver->Solve(springs, {}, {}, &positions, nullptr);
    EXPECT_TRUE(report.converged) << frame;
    EXPECT_LE(report.cg_iterations, 60) << frame;
    if (frame % 4 == 1) {
      EXPECT_LT(LargestDistance(positions, Minimizer(mesh, SoftTissue(), springs, {}, positions)),
                0.05)
          << frame;
    }
  }
  std::vector<Index> component;
  EXPECT_EQ(TetComponents(mesh.tets, &component), 2);
}

TEST(KerfSolver, ALimitOfIterationsIsKeptAndSaidAndTheNextFramesGoOn) {
  const TetMesh mesh = Kidney(5);
  Springs springs = SurfaceSprings(mesh, 150, 1e4);
  MoveTargets(mesh, 1.0, &springs);
  Points result[2];
  for (Points& positions : result) {
    auto solver = MakeKerfSolver();
    solver->Reset(mesh, SoftTissue());
    SolveOptions options;
    options.most_iterations = 4;
    positions = mesh.rest;
    SolveReport report = solver->Solve(springs, {}, options, &positions, nullptr);
    EXPECT_FALSE(report.converged);
    EXPECT_EQ(report.cg_iterations, 4);
    for (int call = 0; call < 30 && !report.converged; ++call) {
      report = solver->Solve(springs, {}, options, &positions, nullptr);
      EXPECT_LE(report.cg_iterations, 4);
    }
    EXPECT_TRUE(report.converged);
    EXPECT_LT(LargestDistance(positions, Minimizer(mesh, SoftTissue(), springs, {}, positions)),
              0.05);
  }
  EXPECT_EQ(result[0], result[1]);
}

/// Twelve vertices of a small kidney split one after the other while it moves. @return the
/// positions of the last frame
Points AfterRandomSplits(unsigned seed, int threads) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  TetMesh mesh = Kidney(2);
  Springs springs = SurfaceSprings(mesh, 20, 1e4);
  auto solver = MakeKerfSolver();
  solver->Reset(mesh, SoftTissue());
  SolveOptions options;
  options.threads = threads;
  Points positions = mesh.rest;
  for (int frame = 0; frame < 4; ++frame) {
    for (int split = 0; split < 3; ++split) {
      const Index vertex = static_cast<Index>(random() % mesh.VertexCount());
      const Vec3 normal = testing::DrawVec3([&] { return uniform(random); });
      const TopologyChange change = testing::SplitVertex(mesh, vertex, normal, random() % 2 == 0);
      if (!change.changed) continue;
      springs.at = change.MapEmbedding(springs.at, mesh);
      positions = change.MapVertexField(positions);
      mesh = change.mesh;
      solver->Apply(change);
    }
    MoveTargets(mesh, 0.1 * frame, &springs);
    const SolveReport report = solver->Solve(springs, {}, options, &positions, nullptr);
    EXPECT_TRUE(report.converged && positions.allFinite()) << seed;
  }
  return positions;
}

TEST(KerfSolver, RandomVertexSplittingNeverFailsAndDependsOnNeitherRunNorThreads) {
  for (unsigned seed = 0; seed < 1000; ++seed) {
    const Points once = AfterRandomSplits(seed, 1);
    ASSERT_EQ(once, AfterRandomSplits(seed, 2)) << seed;
    if (seed % 10 == 0) {
      ASSERT_EQ(once, AfterRandomSplits(seed, 1)) << seed;
    }
  }
}

/// A crack of eight more vertices a frame through a kidney of 4,320 tetrahedra that moves: large
/// enough for the tip to be solved for while the coarse level follows on another thread.
/// @return the positions of all frames
std::vector<Points> WhileACrackGrows(int threads) {
  TetMesh mesh = Kidney(6);
  const double middle = 3.0;
  const std::vector<Index> seam = testing::SeamAt(mesh, middle);
  Springs springs = SurfaceSprings(mesh, 150, 1e4);
  auto solver = MakeKerfSolver();
  solver->Reset(mesh, SoftTissue());
  SolveOptions options;
  options.threads = threads;
  std::vector<Points> frames;
  Points positions = mesh.rest;
  solver->Solve(springs, {}, options, &positions, nullptr);
  for (std::size_t first = 0; first < seam.size(); first += 8) {
    const std::vector<Index> front(seam.begin() + first,
                                   seam.begin() + std::min(first + 8, seam.size()));
    const TopologyChange change = testing::OpenPlane(mesh, front, Vec3::UnitX(), middle);
    springs.at = change.MapEmbedding(springs.at, mesh);
    positions = change.MapVertexField(positions);
    mesh = change.mesh;
    solver->Apply(change);
    MoveTargets(mesh, double(first) / seam.size(), &springs);
    EXPECT_TRUE(solver->Solve(springs, {}, options, &positions, nullptr).converged) << first;
    frames.push_back(positions);
  }
  return frames;
}

TEST(KerfSolver, AGrowingCrackDependsOnNeitherRunNorThreads) {
  const std::vector<Points> once = WhileACrackGrows(1);
  EXPECT_GT(once.size(), 8u);
  for (int run = 0; run < 4; ++run)
    for (const int threads : {2, 3}) {
      const std::vector<Points> again = WhileACrackGrows(threads);
      ASSERT_EQ(again.size(), once.size());
      for (std::size_t f = 0; f < once.size(); ++f)
        ASSERT_EQ(again[f], once[f]) << "frame " << f << ", " << threads << " threads";
    }
}

TEST(KerfSolver, WrongUseIsNamed) {
  const TetMesh mesh = Kidney(2);
  auto solver = MakeKerfSolver();
  solver->Reset(mesh, SoftTissue());
  Points positions = mesh.rest;
  Springs springs = SurfaceSprings(mesh, 5, 1e4);
  springs.targets(2, 1) = std::nan("");
  EXPECT_THROW(solver->Solve(springs, {}, {}, &positions, nullptr), UsageError);
  springs = SurfaceSprings(mesh, 5, 1e4);
  springs.directions = Points::Zero(5, 3);
  EXPECT_THROW(solver->Solve(springs, {}, {}, &positions, nullptr), UsageError);
  positions(0, 0) = std::nan("");
  EXPECT_THROW(solver->Solve(SurfaceSprings(mesh, 5, 1e4), {}, {}, &positions, nullptr),
               UsageError);
}

}  // namespace
}  // namespace kerf
