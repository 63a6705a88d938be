#include "Mechanics/Corotational.h"

#include <algorithm>
#include <string>

#include "Core/Errors.h"

namespace kerf {
namespace {

/// Axial vector a of the skew matrix A − Aᵀ, so that (A − Aᵀ) v = a × v.
Vec3 SkewAxis(const Mat3& A) { return {A(2, 1) - A(1, 2), A(0, 2) - A(2, 0), A(1, 0) - A(0, 1)}; }

Mat3 PolarBySvd(const Mat3& F) {
  const Eigen::JacobiSVD<Mat3> svd(F, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Mat3 U = svd.matrixU();
  // The smallest singular value takes the sign: that is the nearest proper rotation.
  if ((U * svd.matrixV().transpose()).determinant() < 0.0) U.col(2) = -U.col(2);
  return U * svd.matrixV().transpose();
}

}  // namespace

CorotationalElement MakeElement(const TetMesh& mesh, const Material& material, Index tet) {
  CorotationalElement element;
  const auto c = mesh.tets.row(tet);
  Mat3 edges;
  for (int a = 0; a < 3; ++a)
    edges.col(a) = (mesh.rest.row(c[a + 1]) - mesh.rest.row(c[0])).transpose();
  const double determinant = edges.determinant();
  if (!(determinant > 0.0))
    throw UsageError("tetrahedron " + std::to_string(tet) + " has no positive volume at rest");
  element.volume_mm3 = determinant / 6.0;
  element.gradients.rightCols<3>() = edges.inverse().transpose();
  element.gradients.col(0) = -element.gradients.rightCols<3>().rowwise().sum();
  const std::uint8_t region =
      mesh.region.empty() ? static_cast<std::uint8_t>(Label::Organ) : mesh.region[tet];
  element.mu_Pa = material.Mu_Pa(region);
  element.lambda_Pa = material.Lambda_Pa(region);
  return element;
}

Mat3 DeformationGradient(const CorotationalElement& element, const Corners& x) {
  return x * element.gradients.transpose();
}

Mat3 PolarRotation(const Mat3& F, const Mat3& guess) {
  // Newton on the rotation group for max tr(RᵀF). The only local maximum is the global one (the
  // leading eigenvector of a 4×4 form in the quaternion), so where the curvature is definite the
  // result is right; elsewhere the SVD decides.
  Mat3 R = guess;
  for (int iteration = 0; iteration < 8; ++iteration) {
    const Mat3 A = R.transpose() * F;
    const Mat3 G = A.trace() * Mat3::Identity() - 0.5 * (A + A.transpose());
    const Eigen::LLT<Mat3> llt(G);
    if (llt.info() != Eigen::Success || llt.rcond() < 1e-6) break;
    const Vec3 omega = llt.solve(SkewAxis(A));
    R = R * Eigen::Quaterniond(1.0, 0.5 * omega.x(), 0.5 * omega.y(), 0.5 * omega.z())
                .normalized()
                .toRotationMatrix();
    if (omega.squaredNorm() < 1e-20) return R;
  }
  return PolarBySvd(F);
}

double ElementEnergy(const CorotationalElement& element, const Corners& x, const Mat3& R) {
  const Mat3 F = DeformationGradient(element, x);
  const double stretch = (R.array() * F.array()).sum() - 3.0;  // tr(U − I)
  return element.volume_mm3 *
         (0.5 * element.lambda_Pa * stretch * stretch + element.mu_Pa * (F - R).squaredNorm());
}

Corners ElementGradient(const CorotationalElement& element, const Corners& x, const Mat3& R) {
  const Mat3 F = DeformationGradient(element, x);
  const double stretch = (R.array() * F.array()).sum() - 3.0;
  const Mat3 P = 2.0 * element.mu_Pa * (F - R) + element.lambda_Pa * stretch * R;
  return element.volume_mm3 * P * element.gradients;
}

ElementMatrix ElementHessian(const CorotationalElement& element, const Corners& x, const Mat3& R,
                             bool project) {
  // δP = 2μ δF + λ tr(RᵀδF) R + (λ tr(U − I) − 2μ) δR with δR = R [w]×, (tr(U) I − U) w =
  // axis(RᵀδF). In the frame of U the last term and the skew part of the first act on three twists
  // alone: the symmetric 3×3 `twist`.
  const Mat3 U = 0.5 * (R.transpose() * DeformationGradient(element, x) +
                        (R.transpose() * DeformationGradient(element, x)).transpose());
  const Eigen::SelfAdjointEigenSolver<Mat3> eigen(U);
  const double c = element.lambda_Pa * (U.trace() - 3.0) - 2.0 * element.mu_Pa;
  Vec3 stiffness;
  for (int i = 0; i < 3; ++i) {
    const double sum = std::max(U.trace() - eigen.eigenvalues()[i], 1e-6);
    stiffness[i] = c / sum;
    if (project) stiffness[i] = std::max(stiffness[i], -element.mu_Pa);
  }
  const Mat3 twist =
      eigen.eigenvectors() * stiffness.asDiagonal() * eigen.eigenvectors().transpose();
  ElementMatrix H;
  for (int a = 0; a < 4; ++a)
    for (int i = 0; i < 3; ++i) {
      Mat3 dF = Mat3::Zero();
      dF.row(i) = element.gradients.col(a).transpose();
      const Mat3 A = R.transpose() * dF;
      const Vec3 w = twist * SkewAxis(A);
      Mat3 W;
      W << 0, -w.z(), w.y(), w.z(), 0, -w.x(), -w.y(), w.x(), 0;
      const Mat3 dP = 2.0 * element.mu_Pa * dF + element.lambda_Pa * A.trace() * R + R * W;
      const Corners column = element.volume_mm3 * dP * element.gradients;
      H.col(3 * a + i) = Eigen::Map<const Eigen::Matrix<double, 12, 1>>(column.data());
    }
  return H;
}

ElementMatrix WarpedStiffness(const CorotationalElement& element, const Mat3& R) {
  const Corners g = R * element.gradients;
  ElementMatrix K;
  for (int a = 0; a < 4; ++a)
    for (int b = 0; b < 4; ++b)
      K.block<3, 3>(3 * a, 3 * b) =
          element.volume_mm3 * (element.lambda_Pa * g.col(a) * g.col(b).transpose() +
                                element.mu_Pa * (g.col(b) * g.col(a).transpose() +
                                                 g.col(a).dot(g.col(b)) * Mat3::Identity()));
  return K;
}

}  // namespace kerf
