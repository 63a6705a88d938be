#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <thread>

#include "Geometry/SurfaceTree.h"
#include "Support/Draws.h"
#include "Support/TestMeshes.h"

using namespace kerf;

namespace {

SurfaceMesh Box(const Vec3& size) {
  const TetMesh mesh = kerf::testing::BoxMesh(size, 1, 1, 1);
  return BoundarySurface(mesh, mesh.rest);
}

}  // namespace

TEST(SurfaceTree, RayHitsTheNearSideOfASphere) {
  const SurfaceMesh sphere = kerf::testing::SphereSurface({5, -3, 2}, 10.0, 4);
  const SurfaceTree tree(sphere);
  const auto hit = tree.FirstHit({{5, -3, -50}, Vec3::UnitZ()});
  ASSERT_TRUE(hit);
  EXPECT_NEAR(hit->point.z(), -8.0, 0.1);
  EXPECT_NEAR(hit->distance_mm, 42.0, 0.1);
  EXPECT_NEAR(hit->weights.sum(), 1.0, 1e-12);
  EXPECT_GE(hit->weights.minCoeff(), 0.0);
  Vec3 p = Vec3::Zero();
  for (int k = 0; k < 3; ++k)
    p += hit->weights[k] * sphere.points.row(sphere.triangles(hit->triangle, k)).transpose();
  EXPECT_LT((p - hit->point).norm(), 1e-12);
}

TEST(SurfaceTree, RayThatPointsAwayOrPassesBesideMisses) {
  const SurfaceTree tree(kerf::testing::SphereSurface(Vec3::Zero(), 10.0, 3));
  EXPECT_FALSE(tree.FirstHit({{0, 0, -50}, -Vec3::UnitZ()}));
  EXPECT_FALSE(tree.FirstHit({{10.5, 0, -50}, Vec3::UnitZ()}));
}

TEST(SurfaceTree, IsHitSaysWhetherThereIsAFirstHit) {
  const SurfaceTree tree(Box({8, 4, 2}));
  std::mt19937 random(11);
  std::uniform_real_distribution<double> u(-6, 6);
  int hits = 0;
  for (int i = 0; i < 500; ++i) {
    const Vec3 from = kerf::testing::DrawVec3([&] { return u(random); });
    const Vec3 to = kerf::testing::DrawVec3([&] { return u(random); });
    const Ray ray{from, (to - from).normalized()};
    const bool expected = tree.FirstHit(ray).has_value();
    EXPECT_EQ(tree.IsHit(ray), expected) << from.transpose() << " to " << to.transpose();
    hits += expected;
  }
  EXPECT_GT(hits, 50);
  EXPECT_LT(hits, 450);
  for (const double x :
       {-4.0, 0.0, 4.0}) {  // along an edge, through a diagonal's end, along an edge
    const Ray ray{{x, 2.0, -9.0}, Vec3::UnitZ()};
    EXPECT_EQ(tree.IsHit(ray), tree.FirstHit(ray).has_value()) << x;
  }
}

TEST(SurfaceTree, ClosestPointAgreesWithExhaustiveSearch) {
  const SurfaceMesh box = Box({8, 4, 2});
  const SurfaceTree tree(box);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> u(-6, 6);
  for (int i = 0; i < 200; ++i) {
    const Vec3 p = kerf::testing::DrawVec3([&] { return u(random); });
    // Distance to a box in closed form.
    const Vec3 half(4, 2, 1), q = p.cwiseAbs() - half;
    const double expected = q.maxCoeff() > 0 ? q.cwiseMax(0.0).norm() : -q.maxCoeff();
    EXPECT_NEAR(tree.Closest(p).distance_mm, expected, 1e-9) << p.transpose();
  }
}

TEST(SurfaceTree, InsideAgreesWithTheFormula) {
  const SurfaceTree tree(Box({8, 4, 2}));
  std::mt19937 random(3);
  std::uniform_real_distribution<double> u(-5, 5);
  for (int i = 0; i < 500; ++i) {
    const Vec3 p = kerf::testing::DrawVec3([&] { return u(random); });
    const bool expected = (p.cwiseAbs() - Vec3(4, 2, 1)).maxCoeff() < 0;
    EXPECT_EQ(tree.Inside(p), expected) << p.transpose();
  }
}

TEST(SurfaceTree, IsSafeForConcurrentQueries) {
  const SurfaceTree tree(kerf::testing::SphereSurface(Vec3::Zero(), 10.0, 4));
  std::vector<double> first(300), second(300);
  const auto run = [&tree](std::vector<double>* out) {
    for (int i = 0; i < 300; ++i) (*out)[i] = tree.Closest({0.1 * i, 3.0, -0.05 * i}).distance_mm;
  };
  std::thread a(run, &first), b(run, &second);
  a.join();
  b.join();
  EXPECT_EQ(first, second);
}

TEST(SurfaceTree, EmptyAndDegenerateSurfacesDoNotCrash) {
  const SurfaceTree empty{SurfaceMesh{}};
  EXPECT_FALSE(empty.FirstHit({Vec3::Zero(), Vec3::UnitZ()}));
  EXPECT_FALSE(empty.IsHit({Vec3::Zero(), Vec3::UnitZ()}));
  EXPECT_FALSE(empty.Inside(Vec3::Zero()));
  EXPECT_THROW(empty.Closest(Vec3::Zero()), std::invalid_argument);
  SurfaceMesh flat = Box({2, 2, 2});
  flat.triangles.conservativeResize(flat.triangles.rows() + 1, 3);
  flat.triangles.bottomRows<1>() << 0, 0, 1;
  EXPECT_TRUE(SurfaceTree(flat).FirstHit({{0.2, 0.1, -9}, Vec3::UnitZ()}));
}
