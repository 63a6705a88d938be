#include <gtest/gtest.h>

#include <stdexcept>

#include "Evaluation/FeatureError.h"
#include "Evaluation/SurfaceDistance.h"
#include "Support/TestMeshes.h"

namespace kerf {
namespace {

using testing::SphereSurface;

TEST(SurfaceDistance, ConcentricSpheresAreTheirRadiiApart) {
  const auto d = SampledHausdorff(SphereSurface(Vec3::Zero(), 30, 5),
                                  SphereSurface(Vec3::Zero(), 32, 5), 2000);
  ASSERT_TRUE(d.has_value());
  EXPECT_NEAR(d->mean_mm, 2.0, 0.03);
  EXPECT_NEAR(d->max_mm, 2.0, 0.06);
}

TEST(SurfaceDistance, IsTwoSided) {
  // A small sphere beside a large one: seen from one side alone the distance is small.
  SurfaceMesh one = SphereSurface(Vec3::Zero(), 10, 3), both = one;
  const SurfaceMesh far = SphereSurface(Vec3(50, 0, 0), 5, 3);
  both.points.conservativeResize(one.points.rows() + far.points.rows(), 3);
  both.points.bottomRows(far.points.rows()) = far.points;
  both.triangles.conservativeResize(one.triangles.rows() + far.triangles.rows(), 3);
  both.triangles.bottomRows(far.triangles.rows()) =
      far.triangles.array() + static_cast<Index>(one.points.rows());
  const auto a = SampledHausdorff(one, both, 2000), b = SampledHausdorff(both, one, 2000);
  EXPECT_GT(a->max_mm, 40.0);
  EXPECT_GT(b->max_mm, 40.0);
  EXPECT_GT(a->mean_mm, 1.0);
}

TEST(SurfaceDistance, IsDeterministicAndSeeded) {
  const auto a = SphereSurface(Vec3::Zero(), 30, 3), b = SphereSurface(Vec3(1, 0, 0), 30, 3);
  EXPECT_EQ(SampledHausdorff(a, b, 500, 3)->mean_mm, SampledHausdorff(a, b, 500, 3)->mean_mm);
  EXPECT_NE(SampledHausdorff(a, b, 500, 3)->mean_mm, SampledHausdorff(a, b, 500, 4)->mean_mm);
  EXPECT_FALSE(SampledHausdorff(a, SurfaceMesh(), 500).has_value());
}

TEST(SurfaceDistance, SamplesAreSpreadByArea) {
  // Two squares, one nine times as large as the other.
  SurfaceMesh s;
  s.points.resize(8, 3);
  s.points << 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 10, 0, 0, 13, 0, 0, 13, 3, 0, 10, 3, 0;
  s.triangles.resize(4, 3);
  s.triangles << 0, 1, 2, 0, 2, 3, 4, 5, 6, 4, 6, 7;
  RandomGenerator random(1);
  const Points p = SampleSurface(s, 20000, &random);
  const double small = static_cast<double>((p.col(0).array() < 5).count()) / p.rows();
  EXPECT_NEAR(small, 0.1, 0.01);
  EXPECT_NEAR(p.bottomRows(20000).col(1).minCoeff(), 0.0, 0.01);
  EXPECT_GE(p.minCoeff(), 0.0);
  s.points.setZero();
  EXPECT_THROW(SampleSurface(s, 3, &random), std::invalid_argument);
}

TEST(CarriedPoints, FollowAnAffineMotionOfTheSurface) {
  const SurfaceMesh rest = SphereSurface(Vec3(5, 6, 7), 20, 3);
  Mat3 a;
  a << 1.1, 0.2, 0, -0.1, 0.9, 0.3, 0, 0, 1.2;
  Points current = rest.points * a.transpose();
  current.rowwise() += Vec3(3, -2, 1).transpose();
  RandomGenerator random(0);
  const Points on = SampleSurface(rest, 100, &random);
  const Points carried = CarriedPoints(rest, current, on);
  for (Index i = 0; i < on.rows(); ++i)
    EXPECT_LT((carried.row(i).transpose() - (a * on.row(i).transpose() + Vec3(3, -2, 1))).norm(),
              1e-9);
}

TEST(CarriedPoints, KeepTheOffsetFromTheSurface) {
  const SurfaceMesh rest = SphereSurface(Vec3::Zero(), 20, 4);
  Points moved = rest.points;
  moved.col(0).array() += 4.0;
  Points p(1, 3);
  p << 0, 0, 23;
  EXPECT_LT((CarriedPoints(rest, moved, p).row(0) - Eigen::RowVector3d(4, 0, 23)).norm(), 1e-9);
}

TEST(FeatureErrors, SplitAlongTheLineOfSight) {
  Points truth(3, 3), model(3, 3);
  truth << 0, 0, 100, 10, 0, 100, 0, 0, 50;
  model = truth;
  model(0, 2) += 3.0;  // along the sight of the first: no lateral part
  model(2, 0) += 4.0;  // across
  const auto e = CompareFeatures(model, truth, Vec3::Zero());
  ASSERT_TRUE(e.has_value());
  EXPECT_EQ(e->count, 3);
  EXPECT_NEAR(e->mean_mm, 7.0 / 3, 1e-12);
  EXPECT_NEAR(e->max_mm, 4.0, 1e-12);
  EXPECT_NEAR(e->lateral_mean_mm, 4.0 / 3, 1e-12);
  model(1, 1) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(CompareFeatures(model, truth, Vec3::Zero())->count, 2);
  EXPECT_FALSE(CompareFeatures(Points(0, 3), Points(0, 3), Vec3::Zero()).has_value());
}

}  // namespace
}  // namespace kerf
