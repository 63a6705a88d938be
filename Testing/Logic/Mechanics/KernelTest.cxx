#include <gtest/gtest.h>

#include <random>

#include "Mechanics/BandCholesky.h"
#include "Mechanics/ElementKernels.h"
#include "SpringScene.h"

namespace kerf {
namespace {

/// Eight tetrahedra of a box, one chunk, with the same in double precision.
class Kernels : public ::testing::Test {
 protected:
  void SetUp() override {
    mesh_ = testing::Jitter(testing::BoxMesh({6, 6, 6}, 2, 2, 2), 0.2, 8.0, 5);
    for (int lane = 0; lane < 8; ++lane) {
      elements_.push_back(MakeElement(mesh_, testing::SoftTissue(), 6 * lane));
      SetLane(elements_.back(), lane, &block_);
      SetLaneRotation(Mat3::Identity(), block_, lane, &state_);
      for (int a = 0; a < 4; ++a)
        block_.corner[a][lane] = static_cast<std::uint16_t>(mesh_.tets(6 * lane, a));
    }
  }
  Corners At(const Points& x, int lane) const {
    Corners corners;
    for (int a = 0; a < 4; ++a) corners.col(a) = x.row(mesh_.tets(6 * lane, a)).transpose();
    return corners;
  }
  static std::vector<simd::F4> Single(const Points& x) {
    std::vector<simd::F4> out(x.rows());
    for (Index v = 0; v < x.rows(); ++v)
      out[v] = {static_cast<float>(x(v, 0)), static_cast<float>(x(v, 1)),
                static_cast<float>(x(v, 2)), 0};
    return out;
  }
  static double Distance(const std::vector<simd::F4>& a, const Points& b) {
    double sum = 0.0;
    for (Index v = 0; v < b.rows(); ++v)
      sum += (Vec3(a[v].x, a[v].y, a[v].z) - b.row(v).transpose()).squaredNorm();
    return std::sqrt(sum);
  }

  TetMesh mesh_;
  std::vector<CorotationalElement> elements_;
  ElementBlock block_ = {};
  ElementState state_ = {};
};

TEST_F(Kernels, GradientEnergyAndProductsAreThoseOfTheDoublePrecisionElement) {
  std::mt19937 random(7);
  for (double amount : {0.0, 0.1, 0.5, 1.5, 4.0})  // the last ones invert most tetrahedra
    for (int trial = 0; trial < 20; ++trial) {
      std::normal_distribution<double> noise(0.0, amount);
      Points x = mesh_.rest, p = Points::Random(mesh_.VertexCount(), 3);
      for (Index i = 0; i < x.size(); ++i) x.data()[i] += noise(random);
      std::vector<simd::F4> gradient(x.rows()), product(x.rows());
      const double energy = Linearize(&block_, &state_, 1, Single(x).data(), gradient.data());
      const double curvature = AddProduct(&block_, &state_, 1, Single(p).data(), product.data());
      double expected_energy = 0.0, expected_curvature = 0.0;
      bool degenerate = false;
      Points expected = Points::Zero(x.rows(), 3), expected_product = expected;
      for (int lane = 0; lane < 8; ++lane) {
        const Mat3 F = DeformationGradient(elements_[lane], At(x, lane));
        const Vec3 sigma = Eigen::JacobiSVD<Mat3>(F).singularValues();
        // Where the two smallest singular values cancel, the rotation is arbitrary.
        degenerate |= F.determinant() < 0.0 ? sigma[1] - sigma[2] < 0.2 : sigma[1] + sigma[2] < 0.2;
        const Mat3 R = PolarRotation(F);
        expected_energy += ElementEnergy(elements_[lane], At(x, lane), R);
        const Corners g = ElementGradient(elements_[lane], At(x, lane), R);
        const ElementMatrix H = ElementHessian(elements_[lane], At(x, lane), R, true);
        const Corners dp = At(p, lane);
        const Eigen::Matrix<double, 12, 1> Hp =
            H * Eigen::Map<const Eigen::Matrix<double, 12, 1>>(dp.data());
        expected_curvature += Eigen::Map<const Eigen::Matrix<double, 12, 1>>(dp.data()).dot(Hp);
        for (int a = 0; a < 4; ++a) {
          expected.row(mesh_.tets(6 * lane, a)) += g.col(a).transpose();
          expected_product.row(mesh_.tets(6 * lane, a)) += Hp.segment<3>(3 * a).transpose();
        }
      }
      const double scale = expected_product.norm();
      EXPECT_GE(curvature, 0.0);
      if (degenerate) continue;
      EXPECT_NEAR(energy, expected_energy, 1e-4 * expected_energy + 1e-3);
      EXPECT_LT(Distance(gradient, expected), 1e-3 * expected.norm() + 0.5);
      EXPECT_LT(Distance(product, expected_product), 1e-2 * scale);
      EXPECT_NEAR(curvature, expected_curvature, 1e-2 * expected_curvature);
    }
}

TEST(BandCholesky, ReturnsTheSmallestPivotOfWhatHasADiagonal) {
  for (const float coupling : {0.0f, 0.6f, 1.0f}) {
    BandCholesky factor;
    factor.SetProfile({0});
    factor.Add(2, 2, 4.0f);
    factor.Add(3, 2, 2.0f * coupling);
    factor.Add(3, 3, 1.0f);
    EXPECT_NEAR(factor.Factor(), 1.0f - coupling * coupling, 1e-6f) << coupling;
  }
}

TEST(BandCholesky, SolvesAndDropsWhatIsSingular) {
  std::mt19937 random(11);
  std::normal_distribution<double> normal;
  for (int n : {1, 7, 8, 9, 50, 131})
    for (int band : {3, 20}) {
      Eigen::MatrixXd L = Eigen::MatrixXd::Zero(n, n);
      for (int i = 0; i < n; ++i) {
        for (int j = std::max(0, i - band); j < i; ++j) L(i, j) = 0.3 * normal(random);
        L(i, i) = 1.0 + std::abs(normal(random));
      }
      Eigen::MatrixXd A = L * L.transpose();
      const int dropped = n > 40 ? 17 : -1;
      if (dropped >= 0) {
        A.row(dropped).setZero();
        A.col(dropped).setZero();
      }
      std::vector<Index> first((n + 7) / 8);
      for (int b = 0; b < static_cast<int>(first.size()); ++b)
        first[b] = std::max(0, 8 * b - band) / 8;
      const int blocks = static_cast<int>(first.size());
      // At once, or the last rows after the others are factored.
      for (int appended : {0, blocks / 3}) {
        BandCholesky factor;
        factor.SetProfile({first.begin(), first.end() - appended});
        for (int block = 0; block < blocks; ++block) {
          if (block == blocks - appended) {
            EXPECT_GT(factor.Factor(), 0.0f);
            factor.Append(appended, first[block]);
          }
          for (int i = 8 * block; i < std::min(n, 8 * block + 8); ++i)
            for (int j = std::max(0, i - band); j <= i; ++j)
              factor.Add(i, j, static_cast<float>(A(i, j)));
        }
        factor.Factor(appended > 0 ? blocks - appended : 0);
        Eigen::VectorXd x = Eigen::VectorXd::Random(n);
        if (dropped >= 0) x[dropped] = 0.0;
        const Eigen::VectorXd b = A * x;
        std::vector<float> solution(8 * first.size(), 0.0f);
        for (int i = 0; i < n; ++i) solution[i] = static_cast<float>(b[i]);
        factor.Solve(solution.data());
        for (int i = 0; i < n; ++i) EXPECT_NEAR(solution[i], x[i], 2e-3) << n << ' ' << i;
      }
    }
}

}  // namespace
}  // namespace kerf
