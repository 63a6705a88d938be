// What holds for the default solver whatever the problem: the double-precision minimizer's result,
// frames of reference, memory.
#include <gtest/gtest.h>
#include <malloc.h>

#include "Mechanics/ElasticSystem.h"
#include "Mechanics/ExactSolver.h"
#include "Mechanics/FeatureForces.h"
#include "SpringScene.h"
#include "Support/Draws.h"

namespace kerf {
namespace {

using testing::Kidney;
using testing::LargestDistance;
using testing::SoftTissue;
using testing::SurfaceSprings;

TEST(FeatureForces, GradientIsTheDerivativeOfEnergyAndTheMatrixBoundsIt) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  const auto draw = [&] { return testing::DrawVec3([&] { return normal(random); }); };
  for (const double along : {1.0, 0.2, 0.0})
    for (const double scale : {0.0, 0.7, 3.0})
      for (int trial = 0; trial < 20; ++trial) {
        Springs springs;
        springs.at.tet = {0};
        springs.at.weights = Weights4::Constant(1, 4, 0.25);
        springs.targets.resize(1, 3);
        springs.targets.row(0) = draw().transpose();
        springs.stiffness = Eigen::VectorXd::Constant(1, 800.0);
        springs.directions.resize(1, 3);
        springs.directions.row(0) = draw().normalized().transpose();
        springs.along_factor = along;
        springs.robust_scale_mm = scale;
        const Vec3 p = draw() * 2.0, step = draw();
        const SpringState at = EvaluateSpring(springs, 0, p);
        const double h = 1e-5;
        for (int i = 0; i < 3; ++i) {
          const Vec3 d = h * Vec3::Unit(i);
          const double slope = (EvaluateSpring(springs, 0, p + d).energy_nJ -
                                EvaluateSpring(springs, 0, p - d).energy_nJ) /
                               (2.0 * h);
          EXPECT_NEAR(slope, at.gradient[i], 1e-6 * (1.0 + at.gradient.norm()));
        }
        const double model =
            at.energy_nJ + at.gradient.dot(step) + 0.5 * step.dot(at.matrix * step);
        const double energy = EvaluateSpring(springs, 0, p + step).energy_nJ;
        EXPECT_LE(energy, model + 1e-9 * model);
        if (scale == 0.0) {
          EXPECT_NEAR(energy, model, 1e-9 * model);
        }
      }
}

/// What the springs of a problem are, beside quadratic and isotropic.
struct Kind {
  const char* name;
  double robust_scale_mm, along_factor;
  bool tumour, fixed, inertia;
};

class AgreesWithTheYardstick : public ::testing::TestWithParam<Kind> {};

TEST_P(AgreesWithTheYardstick, InPositionsAndEnergy) {
  const Kind& kind = GetParam();
  TetMesh mesh = testing::Jitter(Kidney(4), 0.2, 8.0, 3);
  Material material = SoftTissue();
  if (kind.tumour) {
    material.tumour_stiffness_factor = 10.0;
    testing::PaintSphere({15, 0, 0}, 14.0, Label::Tumour, &mesh);
  }
  Springs springs = SurfaceSprings(mesh, 90, 5e3);
  testing::MoveTargets(mesh, 0.6, &springs);
  springs.robust_scale_mm = kind.robust_scale_mm;
  if (kind.robust_scale_mm > 0.0)
    for (Index l = 0; l < springs.at.Size(); l += 9) springs.targets(l, 1) += 12.0;
  if (kind.along_factor < 1.0) {
    springs.along_factor = kind.along_factor;
    springs.directions = Points::Zero(springs.at.Size(), 3);
    for (Index l = 0; l < springs.at.Size(); ++l)
      springs.directions.row(l) =
          Vec3(0.01 * springs.targets(l, 0), 0.0, 1.0).normalized().transpose();
  }
  Fixations fixations;
  for (Index v = 0; kind.fixed && v < mesh.VertexCount(); ++v)
    if (mesh.rest(v, 0) < -40.0) fixations.vertices.push_back(v);
  fixations.targets.resize(static_cast<Index>(fixations.vertices.size()), 3);
  for (std::size_t i = 0; i < fixations.vertices.size(); ++i)
    fixations.targets.row(static_cast<Index>(i)) = mesh.rest.row(fixations.vertices[i]);
  fixations.stiffness_g_s2 = kind.fixed ? 1e5 : 0.0;
  SolveOptions options;
  options.inertia = kind.inertia;
  Points positions = mesh.rest, velocities = Points::Zero(mesh.VertexCount(), 3);
  velocities.col(2).setConstant(20.0);
  // The yardstick's inertia: each vertex is held by m/h² where its velocity takes it.
  Springs held = springs;
  if (kind.inertia) {
    ElasticSystem system;
    system.Reset(mesh, material);
    const double h = options.time_step_s;
    Embedding vertices;
    vertices.tet.assign(mesh.VertexCount(), -1);
    vertices.weights = Weights4::Zero(mesh.VertexCount(), 4);
    for (Index t = 0; t < mesh.TetCount(); ++t)
      for (int a = 0; a < 4; ++a) {
        const Index v = mesh.tets(t, a);
        if (vertices.tet[v] >= 0) continue;
        vertices.tet[v] = t;
        vertices.weights(v, a) = 1.0;
      }
    const Index n = springs.at.Size(), all = n + mesh.VertexCount();
    held.at.tet.insert(held.at.tet.end(), vertices.tet.begin(), vertices.tet.end());
    held.at.weights.conservativeResize(all, 4);
    held.at.weights.bottomRows(mesh.VertexCount()) = vertices.weights;
    held.targets.conservativeResize(all, 3);
    held.targets.bottomRows(mesh.VertexCount()) = mesh.rest + h * velocities;
    held.stiffness.conservativeResize(all);
    held.stiffness.tail(mesh.VertexCount()) = system.Mass() / (h * h);
  }
  auto solver = MakeKerfSolver();
  solver->Reset(mesh, material);
  SolveReport report = solver->Solve(springs, fixations, options, &positions, &velocities);
  // Robust weights are renewed with every step; a call more is what a next frame gives.
  for (int call = 0; call < 4 && !kind.inertia; ++call)
    report = solver->Solve(springs, fixations, options, &positions, &velocities);
  EXPECT_TRUE(report.converged);
  auto exact = MakeExactSolver();
  exact->Reset(mesh, material);
  SolveOptions tight;
  tight.tolerance = 1e-10;
  Points truth = positions;
  const SolveReport least = exact->Solve(held, fixations, tight, &truth, nullptr);
  ASSERT_TRUE(least.converged);
  EXPECT_LT(LargestDistance(positions, truth), 0.05);
  if (!kind.inertia) {
    EXPECT_LT(report.elastic_energy_uJ + report.spring_energy_uJ,
              1.001 * (least.elastic_energy_uJ + least.spring_energy_uJ));
  }
  // The kind matters: without it the result is another one.
  if (kind.tumour) {
    std::fill(mesh.region.begin(), mesh.region.end(), std::uint8_t{1});
    exact->Reset(mesh, SoftTissue());
    exact->Solve(held, fixations, tight, &truth, nullptr);
    EXPECT_GT(LargestDistance(positions, truth), 0.1);
  }
}

INSTANTIATE_TEST_SUITE_P(Kinds, AgreesWithTheYardstick,
                         ::testing::Values(Kind{"robust", 3.0, 1.0, false, false, false},
                                           Kind{"anisotropic", 0.0, 0.1, false, false, false},
                                           Kind{"tumour", 0.0, 1.0, true, false, false},
                                           Kind{"fixed", 0.0, 1.0, false, true, false},
                                           Kind{"inertia", 0.0, 1.0, false, false, true},
                                           Kind{"all", 3.0, 0.1, true, true, false}),
                         [](const auto& info) { return info.param.name; });

TEST(SolverProperties, ATurnedAndMovedProblemHasTheTurnedAndMovedResult) {
  const TetMesh mesh = Kidney(4);
  const Mat3 turn = Eigen::AngleAxisd(1.3, Vec3(3, -1, 2).normalized()).toRotationMatrix();
  const Eigen::RowVector3d shift(120, -45, 300);
  Points result[2];
  SolveReport report[2];
  for (int moved : {0, 1}) {
    TetMesh here = mesh;
    Springs springs = SurfaceSprings(mesh, 90, 5e3);
    testing::MoveTargets(mesh, 0.6, &springs);
    if (moved) {
      here.rest = (mesh.rest * turn.transpose()).rowwise() + shift;
      springs.targets = (springs.targets * turn.transpose()).eval().rowwise() + shift;
    }
    auto solver = MakeKerfSolver();
    solver->Reset(here, SoftTissue());
    result[moved] = here.rest;
    SolveOptions tight;
    tight.tolerance = 1e-5;
    report[moved] = solver->Solve(springs, {}, tight, &result[moved], nullptr);
    EXPECT_TRUE(report[moved].converged);
  }
  const Points expected = (result[0] * turn.transpose()).rowwise() + shift;
  EXPECT_LT(LargestDistance(result[1], expected), 0.02);
  EXPECT_NEAR(report[1].elastic_energy_uJ, report[0].elastic_energy_uJ,
              1e-3 * report[0].elastic_energy_uJ);
}

/// Bytes that the program has from the system's allocator, as one thread sees them.
std::size_t BytesInUse() {
  const struct mallinfo2 info = mallinfo2();
  return info.uordblks + info.hblkhd;
}

// docs/performance.md: 6 MB of coarse level, its room to grow included, and 330 bytes per
// tetrahedron, the solver's copy of the mesh included.
TEST(SolverProperties, MemoryIsWhatIsStated) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "the sanitizers' allocator is not counted";
#endif
  for (const int n : {9, 13}) {
    const TetMesh mesh = Kidney(n);
    const Springs springs = SurfaceSprings(mesh, 225, 1e4);
    Points positions = mesh.rest;
    SolveOptions options;
    options.threads = 1;
    const std::size_t before = BytesInUse();
    auto solver = MakeKerfSolver();
    solver->Reset(mesh, SoftTissue());
    solver->Solve(springs, {}, options, &positions, nullptr);
    const double bytes = static_cast<double>(BytesInUse()) - static_cast<double>(before);
    EXPECT_LT(bytes, 4.9e6 + 340.0 * mesh.TetCount()) << mesh.TetCount();
    EXPECT_GT(bytes, 128.0 * mesh.TetCount()) << "not what the blocks alone need";
  }
}

}  // namespace
}  // namespace kerf
