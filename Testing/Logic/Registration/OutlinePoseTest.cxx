// A pose that is wrong by 3 mm and 2 degrees, and what the organ's outline makes of it.
#include <gtest/gtest.h>

#include <cmath>

#include "Registration/OrganMask.h"
#include "Registration/OutlinePose.h"
#include "Support/TestCameras.h"
#include "Support/TestMeshes.h"

namespace kerf {
namespace {

/// Longer than wide, with a shoulder on one side: its outline tells every turn.
TetMesh Organ() {
  TetMesh mesh = testing::EllipsoidMesh({48, 26, 20}, 6);
  for (Index v = 0; v < mesh.VertexCount(); ++v)
    mesh.rest(v, 1) += 9.0 * std::tanh(mesh.rest(v, 0) / 15.0);
  return mesh;
}

CameraModel TrueCamera() { return testing::PinholeAbove(960, 540, 900, 160); }

CameraModel WrongBy(double degrees, const Vec3& axis, const Vec3& shift_mm) {
  CameraModel camera = TrueCamera();
  const Vec3 center = camera.camera_from_world.translation();
  Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
  motion.linear() = Eigen::AngleAxisd(degrees * M_PI / 180.0, axis.normalized()).matrix();
  motion.translation() = center - motion.linear() * center + shift_mm;
  camera.camera_from_world = motion * camera.camera_from_world;
  return camera;
}

/// Mean distance of the organ's vertices across the line of sight between two poses, mm.
double Lateral_mm(const TetMesh& mesh, const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  double sum = 0.0;
  for (Index v = 0; v < mesh.VertexCount(); ++v) {
    const Vec3 p = mesh.rest.row(v).transpose();
    sum += ((a * p) - (b * p)).head<2>().norm();
  }
  return sum / static_cast<double>(mesh.VertexCount());
}

struct Seen {
  Image mask;
  Image operator()(const Image&) const { return mask; }
};

OutlinePoseOptions Usual() {
  OutlinePoseOptions options;
  options.turn_deg = 3.0;
  options.shift_mm = 4.0;
  return options;
}

TEST(OutlinePose, AWrongPoseIsPulledIn) {
  const TetMesh mesh = Organ();
  const CameraModel truth = TrueCamera();
  const Seen seen{ProjectedMask(BoundarySurface(mesh, mesh.rest), truth)};
  for (const Vec3& axis : {Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1), Vec3(1, -1, 1)}) {
    const CameraModel wrong = WrongBy(2.0, axis, Vec3(-1.9, 1.6, 1.6));
    const OutlinePose fit = FitPoseToOutline(mesh, wrong, seen, Usual());
    EXPECT_GT(fit.before_px, 4.0);
    EXPECT_LE(fit.after_px, 1.5);
    EXPECT_GT(Lateral_mm(mesh, wrong.camera_from_world, truth.camera_from_world), 2.0);
    EXPECT_LT(Lateral_mm(mesh, fit.camera_from_world, truth.camera_from_world), 0.6)
        << axis.transpose();
  }
}

TEST(OutlinePose, ATruePoseStays) {
  const TetMesh mesh = Organ();
  const CameraModel truth = TrueCamera();
  Seen seen{ProjectedMask(BoundarySurface(mesh, mesh.rest), truth)};
  seen.mask.data[0] = 255;  // a speck, so that it is not the projection itself
  const OutlinePose fit = FitPoseToOutline(mesh, truth, seen, Usual());
  EXPECT_GT(fit.points, 12);
  EXPECT_LE(fit.before_px, 1.5);
  EXPECT_LT(Lateral_mm(mesh, fit.camera_from_world, truth.camera_from_world), 0.2);
}

TEST(OutlinePose, WhatHidesAnEndDoesNotDrawIt) {
  const TetMesh mesh = Organ();
  const CameraModel truth = TrueCamera();
  Seen seen{ProjectedMask(BoundarySurface(mesh, mesh.rest), truth)};
  for (int v = 0; v < seen.mask.height; ++v)  // other tissue lies over the organ's right end
    for (int u = 700; u < seen.mask.width; ++u) seen.mask.data[v * seen.mask.width + u] = 0;
  const CameraModel wrong = WrongBy(2.0, {1, -1, 1}, Vec3(-1.9, 1.6, 1.6));
  const OutlinePose fit = FitPoseToOutline(mesh, wrong, seen, Usual());
  EXPECT_LT(Lateral_mm(mesh, fit.camera_from_world, truth.camera_from_world), 0.8);
}

TEST(OutlinePose, WithoutAnOutlineThePoseIsTheGivenOne) {
  const TetMesh mesh = Organ();
  const CameraModel wrong = WrongBy(2.0, {1, 0, 0}, Vec3(3, 0, 0));
  const Seen nothing{Image{960, 540, 1, std::vector<std::uint8_t>(960 * 540, 0)}};
  const OutlinePose fit = FitPoseToOutline(mesh, wrong, nothing, Usual());
  EXPECT_EQ(fit.points, 0);
  EXPECT_TRUE(fit.camera_from_world.matrix() == wrong.camera_from_world.matrix());
}

TEST(OutlinePose, ASegmenterThatSawNothingMovesNothing) {
  const TetMesh mesh = Organ();
  const CameraModel wrong = WrongBy(2.0, {1, 0, 0}, Vec3(3, 0, 0));
  const OutlinePose fit = FitPoseToOutline(
      mesh, wrong, [](const Image& model) { return model; }, Usual());
  EXPECT_EQ(fit.points, 0);
  EXPECT_TRUE(fit.camera_from_world.matrix() == wrong.camera_from_world.matrix());
}

}  // namespace
}  // namespace kerf
