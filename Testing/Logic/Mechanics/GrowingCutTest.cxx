#include <gtest/gtest.h>

#include <random>
#include <set>

#include "Mechanics/ExactSolver.h"
#include "Mechanics/PatchSolver.h"
#include "Mechanics/RecycledModes.h"
#include "SpringScene.h"
#include "VertexSplitting.h"

namespace kerf {
namespace {

using testing::Kidney;
using testing::LargestDistance;
using testing::SoftTissue;

/// Vertices between the sides of x = 3, by y.
std::vector<std::pair<double, Index>> Seam(const TetMesh& mesh) {
  std::vector<std::pair<double, Index>> seam;
  std::vector<char> sides(mesh.VertexCount(), 0);
  for (Index t = 0; t < mesh.TetCount(); ++t) {
    double x = 0.0;
    for (Index v : mesh.tets.row(t)) x += 0.25 * mesh.rest(v, 0);
    for (Index v : mesh.tets.row(t)) sides[v] |= x > 3.0 ? 2 : 1;
  }
  for (Index v = 0; v < mesh.VertexCount(); ++v)
    if (sides[v] == 3) seam.emplace_back(mesh.rest(v, 1), v);
  std::sort(seam.begin(), seam.end());
  return seam;
}

/// The cut grows by five vertices of the seam.
TopologyChange Grow(const TetMesh& mesh, const std::vector<std::pair<double, Index>>& seam,
                    int frame) {
  std::vector<Index> front;
  for (int i = 5 * frame; i < 5 * frame + 5; ++i) front.push_back(seam[i].second);
  return testing::OpenPlane(mesh, front, Vec3::UnitX(), 3.0);
}

CoarseSpace::Change Follow(CoarseSpace* space, const Workers& workers,
                           const std::vector<Vec3>& rest, const ElementField& field,
                           const ElementField::Patch& patch) {
  space->FollowVertices(rest, field, patch);
  for (Index chunk : patch.chunks) space->FollowChunk(field, chunk);
  const CoarseSpace::Change how = space->FollowNodes(field, patch);
  space->AssembleGrown(workers, field);
  return how;
}

/// Rest positions of inner vertices.
std::vector<Vec3> InnerRest(const TetMesh& mesh, const ElementField& field) {
  std::vector<Vec3> out(field.VertexCount(), Vec3::Zero());
  for (Index v = 0; v < mesh.VertexCount(); ++v) out[field.Inner(v)] = mesh.rest.row(v).transpose();
  return out;
}

/// Vertices that share no tetrahedron, none at the boundary, each moved at rest towards a neighbor.
TopologyChange MoveAtRest(const TetMesh& mesh, double part) {
  const Index n = mesh.VertexCount();
  TopologyChange change;
  change.mesh = mesh;
  change.changed = true;
  change.vertex_weights = Weights4::Zero(n, 4);
  change.vertex_weights.col(0).setOnes();
  for (Index v = 0; v < n; ++v) change.vertex_parents.push_back({v, v, v, v});
  std::vector<Index> boundary;
  BoundarySurface(mesh, mesh.rest, &boundary);
  std::vector<char> stays(n, 0), moves(n, 0);
  for (Index v : boundary) stays[v] = 1;
  for (Index t = 0; t < mesh.TetCount(); ++t) {
    const Index v = mesh.tets(t, 0), to = mesh.tets(t, 1);
    if (stays[v]) continue;
    moves[v] = 1;
    change.vertex_parents[v] = {v, to, v, v};
    change.vertex_weights.row(v) << 1.0 - part, part, 0.0, 0.0;
    change.mesh.rest.row(v) = (1.0 - part) * mesh.rest.row(v) + part * mesh.rest.row(to);
    for (Index u = 0; u < mesh.TetCount(); ++u)
      if ((mesh.tets.row(u).array() == v).any())
        for (Index corner : mesh.tets.row(u)) stays[corner] = 1;
  }
  for (Index t = 0; t < mesh.TetCount(); ++t) {
    bool changed = false;
    for (Index v : mesh.tets.row(t)) changed |= moves[v] != 0;
    change.parent_tet.push_back(t);
    change.kept_tet.push_back(changed ? -1 : t);
    if (changed) change.new_tets.push_back(t);
  }
  return change;
}

/// A field that is linearized at a bent shape.
class Fields : public ::testing::Test {
 protected:
  void SetUp() override {
    mesh_ = testing::Jitter(Kidney(5), 0.2, 8.0, 2);
    field_.Reset(mesh_, SoftTissue());
    x_.resize(3 * mesh_.VertexCount());
    for (Index v = 0; v < mesh_.VertexCount(); ++v) {
      const Vec3 rest = mesh_.rest.row(v).transpose();
      const Vec3 at(rest.x() * 1.05, rest.y(), rest.z() + 0.002 * rest.x() * rest.x());
      for (int i = 0; i < 3; ++i) x_[3 * field_.Inner(v) + i] = at[i];
    }
    field_.Linearize(workers_, Single().data(), false);
  }
  std::vector<simd::F4> Single() const {
    std::vector<simd::F4> out(x_.size() / 3);
    for (std::size_t v = 0; v < out.size(); ++v)
      out[v] = {static_cast<float>(x_[3 * v]), static_cast<float>(x_[3 * v + 1]),
                static_cast<float>(x_[3 * v + 2]), 0.0f};
    return out;
  }

  TetMesh mesh_;
  Workers workers_;
  ElementField field_;
  std::vector<double> x_;  ///< by inner vertex
};

TEST_F(Fields, SurroundingsAreTheVerticesThatTetrahedraConnect) {
  std::set<Index> expected = {7, 300};
  for (int ring = 0; ring < 2; ++ring) {
    const std::set<Index> before = expected;
    for (Index t = 0; t < mesh_.TetCount(); ++t) {
      bool touched = false;
      for (Index v : mesh_.tets.row(t)) touched |= before.count(field_.Inner(v)) > 0;
      if (touched)
        for (Index v : mesh_.tets.row(t)) expected.insert(field_.Inner(v));
    }
    EXPECT_EQ(field_.Surroundings({7, 300}, ring + 1),
              std::vector<Index>(expected.begin(), expected.end()));
  }
}

// A cutter may write a copy as a corner of a tetrahedron: the original is not the first parent.
TEST_F(Fields, ACopyStemsFromTheParentOfAllItsWeight) {
  TopologyChange change = testing::SplitVertex(mesh_, 41, Vec3(1, 0, 0), false);
  ASSERT_TRUE(change.changed);
  change.vertex_parents.back() = {7, 9, 41, 12};
  change.vertex_weights.row(mesh_.VertexCount()) << 0, 0, 1, 0;
  const Index original = field_.Inner(41);
  const ElementField::Patch patch = field_.Apply(workers_, change.mesh, SoftTissue(), change);
  EXPECT_EQ(patch.origins, std::vector<Index>{original});
}

// Chunks that lose tetrahedra, get others in their places, more than that, or both.
TEST_F(Fields, AChunkChangedInPlaceHasTheForcesOfTheNewMesh) {
  const Index n = mesh_.VertexCount();
  const std::set<Index> quartered = {0, 17, 18, 901, 902, 903};
  TopologyChange change;
  change.changed = true;
  change.kept_tet.assign(mesh_.TetCount(), -1);
  std::vector<std::array<Index, 4>> tets;
  std::vector<Vec3> middles;
  const auto add = [&](Index parent, const std::array<Index, 4>& corners) {
    change.parent_tet.push_back(parent);
    tets.push_back(corners);
  };
  for (Index t = 0; t < mesh_.TetCount(); ++t) {
    const auto row = mesh_.tets.row(t);
    const std::array<Index, 4> corners = {row[0], row[1], row[2], row[3]};
    if (quartered.count(t) > 0) {
      Vec3 middle = Vec3::Zero();
      for (const Index v : corners) middle += 0.25 * mesh_.rest.row(v).transpose();
      for (int a = 0; a < 4; ++a) {
        change.new_tets.push_back(static_cast<Index>(tets.size()));
        std::array<Index, 4> part = corners;
        part[a] = n + static_cast<Index>(middles.size());
        add(t, part);
      }
      change.vertex_parents.push_back(corners);
      middles.push_back(middle);
    } else if (t >= 200 || t % 5 != 3) {  // the others are gone
      change.kept_tet[t] = static_cast<Index>(tets.size());
      add(t, corners);
    }
  }
  const Index count = n + static_cast<Index>(middles.size());
  change.mesh.rest.resize(count, 3);
  change.mesh.rest.topRows(n) = mesh_.rest;
  change.vertex_weights = Weights4::Constant(count, 4, 0.25);
  change.vertex_weights.topRows(n).setZero();
  change.vertex_weights.topRows(n).col(0).setOnes();
  for (Index v = n; v < count; ++v) change.mesh.rest.row(v) = middles[v - n].transpose();
  change.vertex_parents.insert(change.vertex_parents.begin(), n, {});
  for (Index v = 0; v < n; ++v) change.vertex_parents[v] = {v, v, v, v};
  change.mesh.tets.resize(static_cast<Index>(tets.size()), 4);
  for (std::size_t t = 0; t < tets.size(); ++t)
    for (int a = 0; a < 4; ++a) change.mesh.tets(static_cast<Index>(t), a) = tets[t][a];
  change.mesh.region.assign(tets.size(), mesh_.region[0]);

  field_.Apply(workers_, change.mesh, SoftTissue(), change);
  std::set<Index> held;
  for (const ElementField::Chunk& chunk : field_.Chunks())
    for (Index t : chunk.tet) EXPECT_TRUE(held.insert(t).second) << t;
  EXPECT_EQ(held.size(), tets.size());
  ElementField anew;
  anew.Reset(change.mesh, SoftTissue());
  const auto linearize = [&](ElementField* field) {
    std::vector<simd::F4> x(field->VertexCount());
    for (Index v = 0; v < count; ++v) {
      const Vec3 at = change.mesh.rest.row(v).transpose();
      x[field->Inner(v)] = {static_cast<float>(1.05 * at.x()), static_cast<float>(at.y()),
                            static_cast<float>(at.z() + 0.002 * at.x() * at.x()), 0.0f};
    }
    return field->Linearize(workers_, x.data(), false);
  };
  const double energy = linearize(&field_);
  EXPECT_NEAR(energy, linearize(&anew), 1e-4 * energy);
  const std::vector<double> volume = field_.LumpedVolumes(), expected = anew.LumpedVolumes();
  for (Index v = 0; v < count; ++v) {
    EXPECT_NEAR(volume[field_.Inner(v)], expected[anew.Inner(v)], 1e-4 * expected[anew.Inner(v)]);
    simd::F4 d;
    simd::Store(&d, _mm_sub_ps(field_.GradientAt(field_.Inner(v)), anew.GradientAt(anew.Inner(v))));
    EXPECT_LT(std::abs(d.x) + std::abs(d.y) + std::abs(d.z), 1.0f) << v;
  }
}

TEST_F(Fields, AnExcerptHasTheForcesOfTheWholeAtItsVertices) {
  const std::vector<Index> vertices = field_.Surroundings({41}, 2);
  ElementField::Excerpt excerpt;
  field_.Extract(vertices, &excerpt);
  ASSERT_TRUE(std::equal(vertices.begin(), vertices.end(), excerpt.vertices.begin()));
  const std::vector<simd::F4> whole = Single();
  std::vector<simd::F4> x, gradient(excerpt.vertices.size());
  for (Index v : excerpt.vertices) x.push_back(whole[v]);
  Linearize(excerpt.blocks.data(), excerpt.states.data(), static_cast<int>(excerpt.blocks.size()),
            x.data(), gradient.data());
  float largest = 0.0f;
  for (const simd::F4& g : gradient) largest = std::max(largest, std::abs(g.x));
  ASSERT_GT(largest, 0.0f);
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    simd::F4 expected;
    simd::Store(&expected, field_.GradientAt(vertices[i]));
    EXPECT_NEAR(gradient[i].x, expected.x, 1e-3f * largest);
    EXPECT_NEAR(gradient[i].y, expected.y, 1e-3f * largest);
    EXPECT_NEAR(gradient[i].z, expected.z, 1e-3f * largest);
  }
}

TEST_F(Fields, APatchComesToRestAndNothingElseMoves) {
  Springs springs = testing::SurfaceSprings(mesh_, 60, 1e4);
  FeatureLoads loads;
  loads.Set(springs, {}, mesh_, field_, true);
  loads.Evaluate(Eigen::Isometry3d::Identity(), x_);
  const std::vector<float> anchor(field_.VertexCount(), 1.0f);
  TwoLevelPreconditioner preconditioner;
  std::vector<Vec3> rest(field_.VertexCount());
  for (Index v = 0; v < mesh_.VertexCount(); ++v)
    rest[field_.Inner(v)] = mesh_.rest.row(v).transpose();
  preconditioner.Reset(workers_, rest, field_);
  preconditioner.UpdateCoarse(workers_, field_, loads, anchor);
  preconditioner.UpdateDiagonal(workers_, field_, loads);
  const auto residual = [&] {
    std::vector<simd::F4> r(field_.VertexCount());
    for (Index v = 0; v < field_.VertexCount(); ++v)
      simd::Store(&r[v], _mm_sub_ps(_mm_setzero_ps(), field_.GradientAt(v)));
    loads.ForVertices(0, field_.VertexCount(), [&](Index v, Index l, float w) {
      simd::Store(&r[v],
                  _mm_sub_ps(simd::Load(r[v]),
                             _mm_mul_ps(_mm_set1_ps(w), simd::Load(loads.Loads()[l].gradient))));
    });
    return r;
  };
  const std::vector<Index> patch = field_.Surroundings({41}, 3);
  const auto largest = [&](const std::vector<simd::F4>& r) {
    float most = 0.0f;
    for (Index v : patch) most = std::max(most, simd::Dot3(simd::Load(r[v]), simd::Load(r[v])));
    return std::sqrt(most);
  };
  const std::vector<double> before = x_;
  const std::vector<simd::F4> start = residual();
  PatchSolver solver;
  solver.Solve(patch, {loads, anchor, x_, preconditioner}, &field_, &x_);
  field_.Linearize(workers_, Single().data(), true);  // what the solver marked, no more
  loads.Evaluate(Eigen::Isometry3d::Identity(), x_);
  EXPECT_LT(largest(residual()), 0.2f * largest(start));
  for (Index v = 0; v < field_.VertexCount(); ++v) {
    if (std::binary_search(patch.begin(), patch.end(), v)) continue;
    for (int i = 0; i < 3; ++i) EXPECT_EQ(x_[3 * v + i], before[3 * v + i]);
  }
}

TEST_F(Fields, APatchFollowsItsAnchors) {
  FeatureLoads loads;
  loads.Set({}, {}, mesh_, field_, true);
  TwoLevelPreconditioner preconditioner;
  preconditioner.Reset(workers_, InnerRest(mesh_, field_), field_);
  // Held a millimeter aside, a thousand times as firmly as the tissue holds.
  const std::vector<float> anchor(field_.VertexCount(), 1e8f);
  std::vector<double> anchor_at = x_;
  for (std::size_t i = 0; i < anchor_at.size(); i += 3) anchor_at[i] += 1.0;
  preconditioner.UpdateCoarse(workers_, field_, loads, anchor);
  preconditioner.UpdateDiagonal(workers_, field_, loads);
  const std::vector<Index> patch = field_.Surroundings({41}, 2);
  const std::vector<double> before = x_;
  PatchSolver solver;
  solver.Solve(patch, {loads, anchor, anchor_at, preconditioner}, &field_, &x_);
  for (Index v = 0; v < field_.VertexCount(); ++v) {
    const bool free = std::binary_search(patch.begin(), patch.end(), v);
    EXPECT_NEAR(x_[3 * v] - before[3 * v], free ? 1.0 : 0.0, 0.1) << v;
    EXPECT_NEAR(x_[3 * v + 1] - before[3 * v + 1], 0.0, 0.1) << v;
  }
}

TEST_F(Fields, AModeCorrectsItsOwnMotionAlone) {
  // Records z_k with rᵀz = p_k and an identity of vectors: the mode is the first record.
  RecycledModes modes;
  const Index n = field_.VertexCount();
  const Index terms = 6;
  for (int k = 0; k < terms; ++k) {
    simd::F4* record = modes.Record(k, n);
    for (Index v = 0; v < n; ++v) record[v] = {k == 0 && v < 10 ? 2.0f : 0.0f, 0, 0, 0};
  }
  Eigen::VectorXd values = Eigen::VectorXd::Constant(terms, 1.0);
  values[0] = 0.1;
  modes.Learn(workers_, n, values, Eigen::MatrixXd::Identity(terms, terms),
              std::vector<double>(terms, 4.0));
  // w is 2/√4 = 1 along x at ten vertices, θ = 0.1: M⁻¹r gets w (wᵀr)/θ.
  std::vector<simd::F4> r(n);
  r[3] = {0.5f, 9.0f, 9.0f, 0};
  r[20] = {7.0f, 0, 0, 0};
  modes.ReserveChunks(1);
  modes.DotChunk(0, 0, n, r.data());
  EXPECT_NEAR(modes.Correct(1), 0.5 * 0.5 / 0.1, 1e-5);
  simd::F4 at;
  simd::Store(&at, modes.At(9));
  EXPECT_NEAR(at.x, 5.0f, 1e-5);
  simd::Store(&at, modes.At(20));
  EXPECT_EQ(at.x, 0.0f);
  modes.Clear();
  EXPECT_EQ(modes.Correct(1), 0.0);
}

TEST(GrowingCut, TheCoarseFactorThatGrewIsThatOfAllFunctionsFactoredAnew) {
  TetMesh mesh = Kidney(6);
  const std::vector<std::pair<double, Index>> seam = Seam(mesh);
  Springs springs = testing::SurfaceSprings(mesh, 225, 1e4);
  const Workers workers;
  ElementField field;
  field.Reset(mesh, SoftTissue());
  const auto rest = [&] { return InnerRest(mesh, field); };
  FeatureLoads loads;
  const auto load = [&] {
    loads.Set(springs, {}, mesh, field, true);
    std::vector<double> x(3 * static_cast<std::size_t>(field.VertexCount()), 0.0);
    loads.Evaluate(Eigen::Isometry3d::Identity(), x);
    return std::vector<float>(field.VertexCount(), 1.0f);
  };
  CoarseSpace space;
  space.Reset(workers, rest(), field);
  std::vector<float> anchor = load();
  space.Factor(workers, field, loads, anchor);
  const Index before = space.FunctionCount();
  std::mt19937 random(3);
  std::normal_distribution<float> normal;
  int grown = 0;
  for (int frame = 0; frame < 20; ++frame) {
    const TopologyChange change = Grow(mesh, seam, frame);
    springs.at = change.MapEmbedding(springs.at, mesh);
    mesh = change.mesh;
    const ElementField::Patch patch = field.Apply(workers, mesh, SoftTissue(), change);
    const CoarseSpace::Change how = Follow(&space, workers, rest(), field, patch);
    ASSERT_NE(how, CoarseSpace::Change::kOther) << frame;
    if (how == CoarseSpace::Change::kNone) continue;
    ++grown;
    anchor = load();
    ASSERT_TRUE(space.Extend(loads, anchor)) << frame;
    CoarseSpace anew = space;
    anew.Factor(workers, field, loads, anchor);
    std::vector<simd::F4> c(space.FunctionCount());
    for (simd::F4& value : c) value = {normal(random), normal(random), normal(random), 0.0f};
    std::vector<simd::F4> expected = c;
    space.Solve(c.data());
    anew.Solve(expected.data());
    float largest = 0.0f, difference = 0.0f;
    for (std::size_t f = 0; f < c.size(); ++f) {
      const __m128 d = _mm_sub_ps(simd::Load(c[f]), simd::Load(expected[f]));
      largest = std::max(largest, simd::Dot3(simd::Load(expected[f]), simd::Load(expected[f])));
      difference = std::max(difference, simd::Dot3(d, d));
    }
    // The anchors of copies came since.
    EXPECT_LT(std::sqrt(difference / largest), 0.01f) << frame;
  }
  EXPECT_GT(grown, 4);
  EXPECT_GT(space.FunctionCount(), before + 8);
}

TEST(GrowingCut, TheCoarseMatrixForgetsTetrahedraThatChangedTheirShape) {
  TetMesh mesh = Kidney(6);
  const Workers workers;
  ElementField field;
  field.Reset(mesh, SoftTissue());
  FeatureLoads loads;
  const std::vector<float> anchor(field.VertexCount(), 1.0f);
  CoarseSpace space;
  space.Reset(workers, InnerRest(mesh, field), field);
  loads.Set({}, {}, mesh, field, true);
  space.Factor(workers, field, loads, anchor);
  const TopologyChange change = MoveAtRest(mesh, 0.3);
  mesh = change.mesh;
  ASSERT_GT(change.new_tets.size(), 300u);
  const ElementField::Patch patch = field.Apply(workers, mesh, SoftTissue(), change);
  ASSERT_FALSE(patch.only_copies);
  Follow(&space, workers, InnerRest(mesh, field), field, patch);
  space.Factor(workers, field, loads, anchor);
  CoarseSpace anew;
  anew.Reset(workers, InnerRest(mesh, field), field);
  anew.Factor(workers, field, loads, anchor);
  // P (PᵀKP)⁻¹ Pᵀ r, whatever the functions' numbers.
  const auto correct = [&](const CoarseSpace& coarse) {
    std::vector<simd::F4> c(coarse.FunctionCount());
    for (Index v = 0; v < field.VertexCount(); ++v)
      for (int k = 0; k < 4; ++k)
        c[coarse.At(v).function[k]].x += coarse.At(v).weight[k] * static_cast<float>(v % 7 - 3);
    coarse.Solve(c.data());
    std::vector<float> x(field.VertexCount(), 0.0f);
    for (Index v = 0; v < field.VertexCount(); ++v)
      for (int k = 0; k < 4; ++k) x[v] += coarse.At(v).weight[k] * c[coarse.At(v).function[k]].x;
    return x;
  };
  const std::vector<float> followed = correct(space), expected = correct(anew);
  float largest = 0.0f, difference = 0.0f;
  for (std::size_t v = 0; v < expected.size(); ++v) {
    largest = std::max(largest, std::abs(expected[v]));
    difference = std::max(difference, std::abs(expected[v] - followed[v]));
  }
  EXPECT_LT(difference, 1e-3f * largest);
}

struct SpringsOnAKidney {
  TetMesh mesh = Kidney(6);
  std::vector<std::pair<double, Index>> seam = Seam(mesh);
  Springs springs = testing::SurfaceSprings(mesh, 225, 1e4);
  std::unique_ptr<ElasticSolver> solver = MakeKerfSolver(), exact = MakeExactSolver();
  SpringsOnAKidney() {
    solver->Reset(mesh, SoftTissue());
    exact->Reset(mesh, SoftTissue());
  }
};

TEST(GrowingCut, WhatACutFreesIsNearItsPlaceBeforeTheWholeIsSolved) {
  auto [mesh, seam, springs, solver, exact] = SpringsOnAKidney();
  testing::MoveTargets(mesh, 1.0, &springs);
  Points positions = mesh.rest;
  SolveOptions tight, hardly;
  tight.tolerance = 1e-6;
  hardly.most_iterations = 1;
  solver->Solve(springs, {}, tight, &positions, nullptr);
  double error = 0.0, moved = 0.0;
  for (int frame = 0; frame < 15; ++frame) {
    const TopologyChange change = Grow(mesh, seam, frame);
    springs.at = change.MapEmbedding(springs.at, mesh);
    positions = change.MapVertexField(positions);
    mesh = change.mesh;
    solver->Apply(change);
    exact->Apply(change);
    Points minimizer = positions;
    exact->Solve(springs, {}, tight, &minimizer, nullptr);
    moved += LargestDistance(positions, minimizer);
    solver->Solve(springs, {}, hardly, &positions, nullptr);
    error += LargestDistance(positions, minimizer);
    solver->Solve(springs, {}, tight, &positions, nullptr);
  }
  EXPECT_LT(error, 0.3 * moved);  // 0.38 without a solve of the tip
}

TEST(GrowingCut, WhatFliesFreelyFliesOnWhileItIsCut) {
  TetMesh mesh = Kidney(6);
  const std::vector<std::pair<double, Index>> seam = Seam(mesh);
  auto solver = MakeKerfSolver();
  solver->Reset(mesh, SoftTissue());
  SolveOptions options;
  options.inertia = true;
  const Eigen::RowVector3d velocity(30.0, -10.0, 20.0);  // mm/s
  Points positions = mesh.rest, velocities = velocity.replicate(mesh.VertexCount(), 1);
  for (int frame = 0; frame < 12; ++frame) {
    const TopologyChange change = Grow(mesh, seam, frame);
    positions = change.MapVertexField(positions);
    velocities = change.MapVertexField(velocities);
    mesh = change.mesh;
    solver->Apply(change);
    const SolveReport report = solver->Solve({}, {}, options, &positions, &velocities);
    EXPECT_TRUE(report.converged) << frame;
  }
  const Points expected = mesh.rest.rowwise() + 12 * options.time_step_s * velocity;
  EXPECT_LT(LargestDistance(positions, expected), 0.01);
  EXPECT_LT((velocities.rowwise() - velocity).cwiseAbs().maxCoeff(), 0.2);
}

TEST(GrowingCut, TakesOneStepOfTheWholeMeshAFrameAndStaysWithinTolerance) {
  auto [mesh, seam, springs, solver, exact] = SpringsOnAKidney();
  Points positions = mesh.rest;
  SolveOptions tight;
  tight.tolerance = 1e-7;
  int steps = 0;
  for (int frame = 0; frame < 25; ++frame) {
    const TopologyChange change = Grow(mesh, seam, frame);
    springs.at = change.MapEmbedding(springs.at, mesh);
    positions = change.MapVertexField(positions);
    mesh = change.mesh;
    testing::MoveTargets(mesh, (frame + 1) / 30.0, &springs);
    solver->Apply(change);
    exact->Apply(change);
    const SolveReport report = solver->Solve(springs, {}, {}, &positions, nullptr);
    EXPECT_TRUE(report.converged) << frame;
    EXPECT_LE(report.cg_iterations, 24) << frame;
    steps += report.steps;
    if (frame % 6 != 5) continue;
    Points minimizer = positions;
    const SolveReport truth = exact->Solve(springs, {}, tight, &minimizer, nullptr);
    EXPECT_LT(LargestDistance(positions, minimizer), 0.05) << frame;
    EXPECT_LT(report.elastic_energy_uJ + report.spring_energy_uJ,
              1.001 * (truth.elastic_energy_uJ + truth.spring_energy_uJ))
        << frame;
  }
  EXPECT_LE(steps, 27);  // two a frame without the patch at the tip
}

}  // namespace
}  // namespace kerf
