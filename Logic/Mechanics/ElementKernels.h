#pragma once

#include "Mechanics/Corotational.h"
#include "Mechanics/Simd.h"

namespace kerf {

/// Eight tetrahedra side by side, single precision: what doesn't change with the state. 52 bytes
/// per tetrahedron.
struct ElementBlock {
  simd::F8 B[9];               ///< ∇N_{a+1} at [3a + i], 1/mm; ∇N_0 is minus their sum
  simd::F8 two_mu, lambda;     ///< times the volume, nJ; zero in padding lanes
  std::uint16_t corner[4][8];  ///< vertices, in the numbering of the chunk
};

/// The linearization of eight tetrahedra. 76 bytes per tetrahedron.
struct ElementState {
  simd::F8 q[4];      ///< rotation R as a unit quaternion w, x, y, z
  simd::F8 RB[9];     ///< R ∇N_{a+1} at [3a + i], 1/mm: with these, products need no rotation
  simd::F8 twist[6];  ///< xx yy zz yz xz xy of R K Rᵀ, K the projected twist stiffness
                      ///< (ElementHessian), times the volume
};

void SetLane(const CorotationalElement& element, int lane, ElementBlock* block);
/// @param block its lane is set
void SetLaneRotation(const Mat3& R, const ElementBlock& block, int lane, ElementState* state);
Mat3 LaneRotation(const ElementState& state, int lane);
/// A quarter of the volume of each tetrahedron, mm³.
simd::F8 QuarterVolumes(const ElementBlock& block);
void CopyLane(const ElementBlock& from, const ElementState& from_state, int from_lane, int lane,
              ElementBlock* to, ElementState* to_state);

/// Lanes after the last one in use repeat it, without stiffness.
void PadLanes(int last, ElementBlock* block, ElementState* state);

/// Rotations (warm-started), projected twist stiffness, energy and gradient of `count` blocks at
/// positions x.
/// @param x positions by chunk vertex, mm; @param gradient is added to; @return energy, nJ
double Linearize(const ElementBlock* blocks, ElementState* states, int count, const simd::F4* x,
                 simd::F4* gradient);

/// y += H p with the projected Hessian of the last linearization. @return pᵀ H p
double AddProduct(const ElementBlock* blocks, const ElementState* states, int count,
                  const simd::F4* p, simd::F4* y);

}  // namespace kerf
