#include <gtest/gtest.h>

#include <random>

#include "Mechanics/Corotational.h"
#include "SpringScene.h"
#include "Support/Draws.h"

namespace kerf {
namespace {

TetMesh OneTet() {
  TetMesh mesh;
  mesh.rest.resize(4, 3);
  mesh.rest << 0, 0, 0, 2.1, 0.1, 0, 0.3, 1.8, 0.2, 0.1, 0.4, 2.3;
  mesh.tets.resize(1, 4);
  mesh.tets << 0, 1, 2, 3;
  mesh.region = {1};
  return mesh;
}

Corners RestCorners(const TetMesh& mesh) { return mesh.rest.transpose(); }

Mat3 RandomRotation(std::mt19937* random) {
  std::normal_distribution<double> normal;
  const Vec3 axis = testing::DrawVec3([&] { return normal(*random); });
  const double w = normal(*random);
  return Eigen::Quaterniond(w, axis.x(), axis.y(), axis.z()).normalized().toRotationMatrix();
}

Mat3 RandomMatrix(std::mt19937* random, double scale) {
  std::normal_distribution<double> normal(0.0, scale);
  Mat3 m;
  for (int i = 0; i < 9; ++i) m(i) = normal(*random);
  return m;
}

double Energy(const CorotationalElement& element, const Corners& x) {
  return ElementEnergy(element, x, PolarRotation(DeformationGradient(element, x)));
}

TEST(PolarRotation, IsNearestProperRotationFromEveryGuess) {
  std::mt19937 random(1);
  for (int i = 0; i < 2000; ++i) {
    const Mat3 F = RandomMatrix(&random, 1.0);  // half of these are inverted
    const Mat3 R = PolarRotation(F, RandomRotation(&random));
    ASSERT_NEAR((R.transpose() * R - Mat3::Identity()).norm(), 0.0, 1e-12);
    ASSERT_NEAR(R.determinant(), 1.0, 1e-12);
    const Mat3 U = R.transpose() * F;
    ASSERT_NEAR((U - U.transpose()).norm(), 0.0, 1e-8);
    // Every other rotation is farther away.
    for (int k = 0; k < 5; ++k) ASSERT_GE((RandomRotation(&random).transpose() * F).trace(), -1e9);
    const double best = U.trace();
    for (int k = 0; k < 20; ++k)
      ASSERT_LE((RandomRotation(&random).transpose() * F).trace(), best + 1e-9);
  }
}

TEST(PolarRotation, GivesARotationForFlatAndZeroMatrices) {
  for (const Mat3& F : {Mat3(Mat3::Zero()), Mat3(Vec3(1, 1, 0).asDiagonal()),
                        Mat3(Vec3(1, 0, 0).asDiagonal()), Mat3(-Mat3::Identity())}) {
    const Mat3 R = PolarRotation(F);
    EXPECT_NEAR((R.transpose() * R - Mat3::Identity()).norm(), 0.0, 1e-12);
    EXPECT_NEAR(R.determinant(), 1.0, 1e-12);
  }
}

TEST(Corotational, UniformStretchHasTheEnergyOfEquation2) {
  const TetMesh mesh = OneTet();
  const Material material = testing::SoftTissue();
  const CorotationalElement element = MakeElement(mesh, material, 0);
  std::mt19937 random(2);
  const Vec3 stretch(1.3, 0.9, 1.05);
  const Mat3 F = RandomRotation(&random) * stretch.asDiagonal();
  const Vec3 strain = stretch - Vec3::Ones();
  const double expected = TetVolume(mesh.rest, mesh.tets, 0) *
                          (0.5 * material.Lambda_Pa(1) * strain.sum() * strain.sum() +
                           material.Mu_Pa(1) * strain.squaredNorm());
  EXPECT_NEAR(Energy(element, F * RestCorners(mesh)), expected, 1e-9 * expected);
}

TEST(Corotational, RigidMotionCostsNothingAndChangesNothing) {
  const TetMesh mesh = OneTet();
  const CorotationalElement element = MakeElement(mesh, testing::SoftTissue(), 0);
  std::mt19937 random(3);
  for (int i = 0; i < 50; ++i) {
    const Mat3 Q = RandomRotation(&random);
    Corners moved = Q * RestCorners(mesh);
    moved.colwise() += Vec3(10, -200, 35);
    EXPECT_LT(Energy(element, moved), 1e-15);
    const Corners x = RestCorners(mesh) + Corners::Random() * 0.4;
    EXPECT_NEAR(Energy(element, Q * x), Energy(element, x), 1e-9 * Energy(element, x));
  }
}

TEST(Corotational, ForceIsMinusTheDerivativeOfEnergy) {
  const TetMesh mesh = OneTet();
  const CorotationalElement element = MakeElement(mesh, testing::SoftTissue(), 0);
  for (int i = 0; i < 50; ++i) {
    const Corners x = RestCorners(mesh) + Corners::Random() * 0.5;
    const Corners g = ElementGradient(element, x, PolarRotation(DeformationGradient(element, x)));
    EXPECT_LT(g.rowwise().sum().norm(), 1e-9 * g.norm());
    const double h = 1e-6;
    for (int k = 0; k < 12; ++k) {
      Corners plus = x, minus = x;
      plus(k) += h;
      minus(k) -= h;
      EXPECT_NEAR((Energy(element, plus) - Energy(element, minus)) / (2 * h), g(k),
                  1e-6 * g.norm());
    }
  }
}

TEST(Corotational, HessianIsTheDerivativeOfTheGradient) {
  const TetMesh mesh = OneTet();
  const CorotationalElement element = MakeElement(mesh, testing::SoftTissue(), 0);
  auto gradient = [&](const Corners& x) {
    return ElementGradient(element, x, PolarRotation(DeformationGradient(element, x)));
  };
  for (int i = 0; i < 30; ++i) {
    const Corners x = RestCorners(mesh) + Corners::Random() * 0.4;
    const Mat3 R = PolarRotation(DeformationGradient(element, x));
    const ElementMatrix H = ElementHessian(element, x, R, false);
    EXPECT_LT((H - H.transpose()).norm(), 1e-9 * H.norm());
    const double h = 1e-6;
    for (int k = 0; k < 12; ++k) {
      Corners plus = x, minus = x;
      plus(k) += h;
      minus(k) -= h;
      const Corners difference = (gradient(plus) - gradient(minus)) / (2 * h);
      for (int j = 0; j < 12; ++j) EXPECT_NEAR(difference(j), H(j, k), 1e-5 * H.norm());
    }
  }
}

TEST(Corotational, ProjectedHessianHasNoNegativeCurvatureAndIsExactWhereThereIsNone) {
  const TetMesh mesh = OneTet();
  const CorotationalElement element = MakeElement(mesh, testing::SoftTissue(), 0);
  int indefinite = 0;
  for (int i = 0; i < 100; ++i) {
    const Corners x = RestCorners(mesh) + Corners::Random() * 0.9;
    const Mat3 R = PolarRotation(DeformationGradient(element, x));
    const ElementMatrix exact = ElementHessian(element, x, R, false);
    const ElementMatrix projected = ElementHessian(element, x, R, true);
    const double scale = projected.norm();
    const Eigen::SelfAdjointEigenSolver<ElementMatrix> eigen(projected), exact_eigen(exact);
    EXPECT_GT(eigen.eigenvalues()[0], -1e-9 * scale);
    if (exact_eigen.eigenvalues()[0] < -1e-9 * scale)
      ++indefinite;
    else
      EXPECT_LT((exact - projected).norm(), 1e-6 * scale);
  }
  EXPECT_GT(indefinite, 10);
}

TEST(Corotational, WarpedStiffnessEqualsTheHessianAtRest) {
  const TetMesh mesh = OneTet();
  const CorotationalElement element = MakeElement(mesh, testing::SoftTissue(), 0);
  std::mt19937 random(4);
  const Mat3 Q = RandomRotation(&random);
  const Corners x = Q * RestCorners(mesh);
  const ElementMatrix H = ElementHessian(element, x, Q, false);
  EXPECT_LT((WarpedStiffness(element, Q) - H).norm(), 1e-9 * H.norm());
}

}  // namespace
}  // namespace kerf
