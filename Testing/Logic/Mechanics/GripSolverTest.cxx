#include <gtest/gtest.h>

#include "Core/Errors.h"
#include "Mechanics/GripSolver.h"
#include "SpringScene.h"
#include "VertexSplitting.h"

namespace kerf {
namespace {

/// A bar held at both ends.
class HeldBar : public ::testing::Test {
 protected:
  void SetUp() override {
    mesh_ = testing::BoxMesh({60, 16, 16}, 12, 3, 3);
    std::vector<std::vector<Index>> grips(2);
    for (Index v = 0; v < mesh_.VertexCount(); ++v) {
      if (mesh_.rest(v, 0) < -25.1) grips[0].push_back(v);
      if (mesh_.rest(v, 0) > 25.1) grips[1].push_back(v);
    }
    solver_.Reset(mesh_, testing::SoftTissue());
    solver_.SetGrips(grips);
  }
  Embedding Centroids() const {
    Embedding points;
    for (Index t = 0; t < mesh_.TetCount(); t += 40) points.tet.push_back(t);
    points.weights = Weights4::Constant(points.Size(), 4, 0.25);
    return points;
  }

  TetMesh mesh_;
  GripSolver solver_;
};

TEST_F(HeldBar, MovesRigidlyWithGripsThatMoveAlike) {
  Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
  motion.rotate(Eigen::AngleAxisd(0.5, Vec3(1, 1, 0).normalized()));
  motion.pretranslate(Vec3(5, -3, 20));
  Points positions = mesh_.rest;
  const GripReport report = solver_.Solve({motion, motion}, {}, &positions);
  EXPECT_TRUE(report.converged);
  EXPECT_LT(report.elastic_energy_uJ, 1e-6);
  for (Index v = 0; v < mesh_.VertexCount(); ++v)
    EXPECT_LT((motion * Vec3(mesh_.rest.row(v).transpose()) - positions.row(v).transpose()).norm(),
              1e-4);
}

TEST_F(HeldBar, SensitivitiesAreTheDerivativesOfTheEquilibrium) {
  std::vector<Eigen::Isometry3d> motions(2, Eigen::Isometry3d::Identity());
  motions[1].translate(Vec3(6, 4, 0));
  motions[1].rotate(Eigen::AngleAxisd(0.4, Vec3::UnitZ()));
  GripOptions tight;
  tight.tolerance_mm = 1e-8;
  Points positions = mesh_.rest;
  ASSERT_TRUE(solver_.Solve(motions, tight, &positions).converged);
  const Embedding points = Centroids();
  const Eigen::MatrixXd J = solver_.Sensitivities(points);
  ASSERT_EQ(J.rows(), 3 * points.Size());
  ASSERT_EQ(J.cols(), 12);
  const double h = 1e-4;
  for (int k = 0; k < 12; ++k) {
    Points side[2];
    for (int sign : {0, 1}) {
      Eigen::Matrix<double, 6, 1> step = Eigen::Matrix<double, 6, 1>::Zero();
      step[k % 6] = sign ? h : -h;
      std::vector<Eigen::Isometry3d> trial = motions;
      trial[k / 6] = solver_.Moved(k / 6, motions[k / 6], step);
      Points moved = positions;
      ASSERT_TRUE(solver_.Solve(trial, tight, &moved).converged);
      side[sign] = points.Positions(moved, mesh_.tets);
    }
    const Points difference = (side[1] - side[0]) / (2 * h);
    for (Index i = 0; i < points.Size(); ++i)
      EXPECT_LT((difference.row(i).transpose() - J.col(k).segment<3>(3 * i)).norm(),
                1e-4 * (1.0 + difference.row(i).norm()));
  }
}

TEST_F(HeldBar, LargeBendingConvergesAndLeavesNoForceOnFreeVertices) {
  std::vector<Eigen::Isometry3d> motions(2, Eigen::Isometry3d::Identity());
  motions[1].pretranslate(Vec3(-10, 25, 0));
  motions[1].rotate(Eigen::AngleAxisd(1.2, Vec3::UnitZ()));
  Points positions = mesh_.rest;
  EXPECT_TRUE(solver_.Solve(motions, {}, &positions).converged);
  EXPECT_GT(MeasureQuality(mesh_, positions).smallest_tet_volume_mm3, 0.0);
}

TEST_F(HeldBar, GripsFollowACut) {
  std::vector<Index> seam;
  for (Index v = 0; v < mesh_.VertexCount(); ++v)
    if (std::abs(mesh_.rest(v, 0)) < 1e-9) seam.push_back(v);
  const TopologyChange change = testing::OpenPlane(mesh_, seam, Vec3::UnitX(), 0.0);
  const std::size_t held = solver_.Grips()[0].size();
  solver_.Apply(change);
  EXPECT_EQ(solver_.Grips()[0].size(), held);
  std::vector<Eigen::Isometry3d> motions(2, Eigen::Isometry3d::Identity());
  motions[1].translate(Vec3(12, 0, 0));
  Points positions = change.MapVertexField(mesh_.rest);
  const GripReport report = solver_.Solve(motions, {}, &positions);
  EXPECT_TRUE(report.converged);
  EXPECT_LT(report.elastic_energy_uJ, 1e-3);  // two pieces, each moves as its grip
}

TEST_F(HeldBar, WrongUseIsNamed) {
  EXPECT_THROW(solver_.SetGrips({{0, 1}, {1, 2}}), UsageError);
  EXPECT_THROW(solver_.SetGrips({{}}), UsageError);
  EXPECT_THROW(solver_.SetGrips({{mesh_.VertexCount()}}), UsageError);
  Points positions = mesh_.rest;
  EXPECT_THROW(solver_.Solve({}, {}, &positions), UsageError);
  EXPECT_THROW(solver_.Sensitivities(Centroids()), UsageError);
}

}  // namespace
}  // namespace kerf
