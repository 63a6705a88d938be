#pragma once

#include "Core/TetMesh.h"
#include "Core/Types.h"
#include "Mechanics/ElasticSolver.h"

namespace kerf {

/// Corotational linear elasticity of one tetrahedron, Eq. (1)–(3), in double precision: value,
/// gradient and Hessian side by side. The reference works with these; the fast solver is tested
/// against them.
///
/// With F = Σ_a x_a ∇N_aᵀ = R U (R a proper rotation, U symmetric; where F is inverted, U has one
/// negative eigenvalue):
///   W_c = V [λ/2 tr(U − I)² + μ tr((U − I)²)],  P = ∂W_c/∂F / V = 2μ (F − R) + λ tr(U − I) R.
/// Units: mm, Pa = g/(mm·s²), hence energies in g·mm²/s² = nJ and forces in g·mm/s² = µN.

/// Columns are the four corners (positions, forces).
using Corners = Eigen::Matrix<double, 3, 4>;
/// 12×12, rows and columns 3a+i for coordinate i of corner a.
using ElementMatrix = Eigen::Matrix<double, 12, 12>;

struct CorotationalElement {
  Corners gradients = Corners::Zero();  ///< columns ∇N_a at rest, 1/mm; they sum to zero
  double volume_mm3 = 0.0;
  double mu_Pa = 0.0, lambda_Pa = 0.0;
};

/// @throws UsageError if the tetrahedron is not positive at rest
CorotationalElement MakeElement(const TetMesh& mesh, const Material& material, Index tet);

Mat3 DeformationGradient(const CorotationalElement& element, const Corners& x);

/// Proper rotation R nearest to F (maximizes tr(RᵀF)); F may be inverted, flat or zero. `guess` (a
/// rotation) makes it faster, it doesn't change the result beyond rounding.
Mat3 PolarRotation(const Mat3& F, const Mat3& guess = Mat3::Identity());

/// W_c, Eq. (2), in nJ.
double ElementEnergy(const CorotationalElement& element, const Corners& x, const Mat3& R);
/// ∂W_c/∂x, columns per corner, in µN (the force is its negative).
Corners ElementGradient(const CorotationalElement& element, const Corners& x, const Mat3& R);
/// ∂²W_c/∂x², exact, or with negative curvature (twists of compressed elements) clamped to zero.
ElementMatrix ElementHessian(const CorotationalElement& element, const Corners& x, const Mat3& R,
                             bool project);
/// R K_e Rᵀ, the warped stiffness of the corotational method (dR/dx neglected), as in the paper's
/// field.
ElementMatrix WarpedStiffness(const CorotationalElement& element, const Mat3& R);

}  // namespace kerf
