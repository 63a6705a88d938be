#include "Mechanics/ElementKernels.h"

#include <algorithm>

namespace kerf {
namespace {

using simd::F8;

struct Matrix8 {
  F8 m[3][3];
};

Matrix8 Rotation(const F8 q[4]) {
  const F8 w = q[0], x = q[1], y = q[2], z = q[3];
  const F8 x2 = x + x, y2 = y + y, z2 = z + z;
  const F8 xx = x * x2, yy = y * y2, zz = z * z2, xy = x * y2, xz = x * z2, yz = y * z2,
           wx = w * x2, wy = w * y2, wz = w * z2;
  return {{{1.0f - yy - zz, xy - wz, xz + wy},
           {xy + wz, 1.0f - xx - zz, yz - wx},
           {xz - wy, yz + wx, 1.0f - xx - yy}}};
}

/// Edge vectors of corners 1–3 from corner 0: e[a][i].
inline void Edges(const simd::F4* values, const ElementBlock& block, F8 e[3][3]) {
  F8 origin[3];
  simd::Gather(values, block.corner[0], origin);
  for (int a = 0; a < 3; ++a) {
    simd::Gather(values, block.corner[a + 1], e[a]);
    for (int i = 0; i < 3; ++i) e[a][i] -= origin[i];
  }
}

/// Σ_a e_a ∇N_aᵀ.
inline Matrix8 Gradient(const F8 e[3][3], const F8 B[9]) {
  Matrix8 F;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      F.m[i][j] = e[0][i] * B[j] + e[1][i] * B[3 + j] + e[2][i] * B[6 + j];
  return F;
}

inline Matrix8 TransposeTimes(const Matrix8& R, const Matrix8& F) {
  Matrix8 A;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      A.m[i][j] = R.m[0][i] * F.m[0][j] + R.m[1][i] * F.m[1][j] + R.m[2][i] * F.m[2][j];
  return A;
}

/// Adds the corner forces T g_a of the stress T (times the volume), g the rotated gradients.
inline void AddForces(const Matrix8& T, const F8 g[9], const ElementBlock& block, simd::F4* out) {
  F8 sum[3] = {};
  for (int a = 0; a < 3; ++a) {
    F8 f[3];
    for (int i = 0; i < 3; ++i) {
      f[i] = T.m[i][0] * g[3 * a] + T.m[i][1] * g[3 * a + 1] + T.m[i][2] * g[3 * a + 2];
      sum[i] -= f[i];
    }
    simd::ScatterAdd(f, block.corner[a + 1], out);
  }
  simd::ScatterAdd(sum, block.corner[0], out);
}

/// Newton for the rotations nearest to F, from q. @return bit mask of the lanes that it did not
/// settle
int PolarNewton(const Matrix8& F, F8 q[4]) {
  int open = 0xFF;
  for (int iteration = 0; iteration < 5 && open != 0; ++iteration) {
    const Matrix8 A = TransposeTimes(Rotation(q), F);
    const F8 a0 = A.m[2][1] - A.m[1][2], a1 = A.m[0][2] - A.m[2][0], a2 = A.m[1][0] - A.m[0][1];
    // G = tr(A) I − sym(A), inverted by its cofactors.
    const F8 g00 = A.m[1][1] + A.m[2][2], g11 = A.m[0][0] + A.m[2][2], g22 = A.m[0][0] + A.m[1][1];
    const F8 g01 = -0.5f * (A.m[0][1] + A.m[1][0]), g02 = -0.5f * (A.m[0][2] + A.m[2][0]),
             g12 = -0.5f * (A.m[1][2] + A.m[2][1]);
    const F8 c00 = g11 * g22 - g12 * g12, c01 = g02 * g12 - g01 * g22, c02 = g01 * g12 - g02 * g11;
    const F8 c11 = g00 * g22 - g02 * g02, c12 = g01 * g02 - g00 * g12, c22 = g00 * g11 - g01 * g01;
    const F8 determinant = g00 * c00 + g01 * c01 + g02 * c02;
    // Definite and not near the degenerate case, where rounding would decide.
    const int definite = simd::Greater(g00, simd::Splat(0.05f)) &
                         simd::Greater(c22, simd::Splat(0.01f)) &
                         simd::Greater(determinant, simd::Splat(0.01f));
    const F8 half = 0.5f / simd::Max(determinant, simd::Splat(0.01f));
    F8 x = half * (c00 * a0 + c01 * a1 + c02 * a2), y = half * (c01 * a0 + c11 * a1 + c12 * a2),
       z = half * (c02 * a0 + c12 * a1 + c22 * a2);
    const F8 size = x * x + y * y + z * z;
    const F8 limit = simd::Min(simd::Splat(1.0f), 1.0f / simd::Sqrt(size + 1e-20f));
    x *= limit;
    y *= limit;
    z *= limit;
    const F8 w0 = q[0], x0 = q[1], y0 = q[2], z0 = q[3];
    const F8 qw = w0 - x0 * x - y0 * y - z0 * z, qx = w0 * x + x0 + y0 * z - z0 * y,
             qy = w0 * y - x0 * z + y0 + z0 * x, qz = w0 * z + x0 * y - y0 * x + z0;
    const F8 norm = 1.0f / simd::Sqrt(qw * qw + qx * qx + qy * qy + qz * qz);
    q[0] = qw * norm;
    q[1] = qx * norm;
    q[2] = qy * norm;
    q[3] = qz * norm;
    // The update squares the error (and better), so a small half angle was the last one needed.
    open = ~(definite & simd::Greater(simd::Splat(1e-6f), size)) & 0xFF;
  }
  return open;
}

/// Eigenvalues on the diagonal of S as Jacobi's rotations find them, eigenvectors in the columns of
/// V.
struct Eigen8 {
  F8 diagonal[3], off[3];  ///< of S; off[k] beside the axis k
  Matrix8 V;
};

/// One Jacobi rotation in the plane (p, q), r the third axis.
inline void JacobiRotate(Eigen8* S, int p, int q, int r) {
  const F8 difference = S->diagonal[q] - S->diagonal[p], twice = S->off[r] + S->off[r];
  const F8 root = simd::Sqrt(difference * difference + twice * twice);
  const F8 adjacent = simd::Abs(difference) + root + 1e-20f;
  const F8 opposite = simd::FlipSign(twice, difference);
  const F8 inverse = 1.0f / simd::Sqrt(adjacent * adjacent + twice * twice);
  const F8 c = adjacent * inverse, s = opposite * inverse;
  const F8 mean = 0.5f * (S->diagonal[p] + S->diagonal[q]);
  const F8 half = simd::WithSign(0.5f * root, difference);
  S->diagonal[p] = mean - half;
  S->diagonal[q] = mean + half;
  S->off[r] = F8{};
  const F8 pr = S->off[q], qr = S->off[p];
  S->off[q] = c * pr - s * qr;
  S->off[p] = s * pr + c * qr;
  for (auto& row : S->V.m) {
    const F8 v = row[p];
    row[p] = c * v - s * row[q];
    row[q] = s * v + c * row[q];
  }
}

/// Blocks that are decomposed together: one waits for its square roots while the other computes.
constexpr int kTogether = 2;

void Decompose(const Matrix8* U, int count, Eigen8* S) {
  for (int k = 0; k < count; ++k) {
    for (int i = 0; i < 3; ++i) {
      const int p = (i + 1) % 3, q = (i + 2) % 3;
      S[k].diagonal[i] = U[k].m[i][i];
      S[k].off[i] = 0.5f * (U[k].m[p][q] + U[k].m[q][p]);
      for (int j = 0; j < 3; ++j) S[k].V.m[i][j] = simd::Splat(i == j ? 1.0f : 0.0f);
    }
  }
  for (int sweep = 0; sweep < 2; ++sweep) {
    for (int k = 0; k < count; ++k) JacobiRotate(&S[k], 0, 1, 2);
    for (int k = 0; k < count; ++k) JacobiRotate(&S[k], 0, 2, 1);
    for (int k = 0; k < count; ++k) JacobiRotate(&S[k], 1, 2, 0);
  }
}

/// c G⁻¹, G = tr(U) I − U, with eigenvalues not below −floor (2μ V / 2): the projection of
/// ElementHessian.
void TwistStiffness(const Eigen8& U, F8 c, F8 floor, F8 out[6]) {
  const F8 trace = U.diagonal[0] + U.diagonal[1] + U.diagonal[2];
  const F8 small = simd::Splat(0.05f);
  F8 stiffness[3];
  for (int k = 0; k < 3; ++k)
    stiffness[k] = simd::Max(c / simd::Max(trace - U.diagonal[k], small), -floor);
  auto entry = [&](int i, int j) {
    return stiffness[0] * U.V.m[i][0] * U.V.m[j][0] + stiffness[1] * U.V.m[i][1] * U.V.m[j][1] +
           stiffness[2] * U.V.m[i][2] * U.V.m[j][2];
  };
  out[0] = entry(0, 0);
  out[1] = entry(1, 1);
  out[2] = entry(2, 2);
  out[3] = entry(1, 2);
  out[4] = entry(0, 2);
  out[5] = entry(0, 1);
}

Mat3 Lane(const Matrix8& M, int lane) {
  Mat3 out;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) out(i, j) = M.m[i][j][lane];
  return out;
}

void SetQuaternion(const Mat3& R, int lane, F8 q[4]) {
  const Eigen::Quaterniond rotation(R);
  q[0][lane] = static_cast<float>(rotation.w());
  q[1][lane] = static_cast<float>(rotation.x());
  q[2][lane] = static_cast<float>(rotation.y());
  q[3][lane] = static_cast<float>(rotation.z());
}

}  // namespace

void SetLane(const CorotationalElement& element, int lane, ElementBlock* block) {
  for (int a = 0; a < 3; ++a)
    for (int i = 0; i < 3; ++i)
      block->B[3 * a + i][lane] = static_cast<float>(element.gradients(i, a + 1));
  block->two_mu[lane] = static_cast<float>(2.0 * element.mu_Pa * element.volume_mm3);
  block->lambda[lane] = static_cast<float>(element.lambda_Pa * element.volume_mm3);
}

void SetLaneRotation(const Mat3& R, const ElementBlock& block, int lane, ElementState* state) {
  SetQuaternion(R, lane, state->q);
  for (int a = 0; a < 3; ++a) {
    const Vec3 g =
        R * Vec3(block.B[3 * a][lane], block.B[3 * a + 1][lane], block.B[3 * a + 2][lane]);
    for (int i = 0; i < 3; ++i) state->RB[3 * a + i][lane] = static_cast<float>(g[i]);
  }
}

Mat3 LaneRotation(const ElementState& state, int lane) {
  return Eigen::Quaterniond(state.q[0][lane], state.q[1][lane], state.q[2][lane], state.q[3][lane])
      .toRotationMatrix();
}

simd::F8 QuarterVolumes(const ElementBlock& block) {
  const F8* B = block.B;
  const F8 determinant = B[0] * (B[4] * B[8] - B[5] * B[7]) + B[1] * (B[5] * B[6] - B[3] * B[8]) +
                         B[2] * (B[3] * B[7] - B[4] * B[6]);
  return (1.0f / 24.0f) / determinant;
}

void CopyLane(const ElementBlock& from, const ElementState& from_state, int from_lane, int lane,
              ElementBlock* to, ElementState* to_state) {
  for (int i = 0; i < 9; ++i) to->B[i][lane] = from.B[i][from_lane];
  to->two_mu[lane] = from.two_mu[from_lane];
  to->lambda[lane] = from.lambda[from_lane];
  for (int i = 0; i < 4; ++i) to_state->q[i][lane] = from_state.q[i][from_lane];
  for (int i = 0; i < 9; ++i) to_state->RB[i][lane] = from_state.RB[i][from_lane];
  for (int i = 0; i < 6; ++i) to_state->twist[i][lane] = from_state.twist[i][from_lane];
}

void PadLanes(int last, ElementBlock* block, ElementState* state) {
  for (int lane = last + 1; lane < 8; ++lane) {
    CopyLane(*block, *state, last, lane, block, state);
    block->two_mu[lane] = block->lambda[lane] = 0.0f;
    for (auto& corner : block->corner) corner[lane] = corner[last];
  }
}

namespace {

/// Rotations and rotated gradients of a block. @return the left stretch V = F Rᵀ: everything in the
/// frame of the image, where forces are wanted
Matrix8 Stretch(const ElementBlock& block, const simd::F4* x, ElementState* state) {
  F8 e[3][3];
  Edges(x, block, e);
  const Matrix8 F = Gradient(e, block.B);
  const int open = PolarNewton(F, state->q);
  for (int lane = 0; lane < 8; ++lane)
    if (open >> lane & 1) SetQuaternion(PolarRotation(Lane(F, lane)), lane, state->q);
  const Matrix8 R = Rotation(state->q);
  for (int a = 0; a < 3; ++a)
    for (int i = 0; i < 3; ++i)
      state->RB[3 * a + i] = R.m[i][0] * block.B[3 * a] + R.m[i][1] * block.B[3 * a + 1] +
                             R.m[i][2] * block.B[3 * a + 2];
  return Gradient(e, state->RB);
}

}  // namespace

double Linearize(const ElementBlock* blocks, ElementState* states, int count, const simd::F4* x,
                 simd::F4* gradient) {
  double energy = 0.0;
  for (int first = 0; first < count; first += kTogether) {
    const int together = std::min(kTogether, count - first);
    Matrix8 V[kTogether];
    Eigen8 eigen[kTogether];
    for (int k = 0; k < together; ++k) V[k] = Stretch(blocks[first + k], x, &states[first + k]);
    Decompose(V, together, eigen);
    for (int k = 0; k < together; ++k) {
      const ElementBlock& block = blocks[first + k];
      ElementState& state = states[first + k];
      Matrix8& T = V[k];
      const F8 stretch = T.m[0][0] + T.m[1][1] + T.m[2][2] - 3.0f;
      TwistStiffness(eigen[k], block.lambda * stretch - block.two_mu, 0.5f * block.two_mu,
                     state.twist);
      // T = 2μ (V − I) + λ tr(V − I) I; energy ½ (2μ |V − I|² + λ tr²).
      F8 squares = F8{};
      for (int i = 0; i < 3; ++i) {
        T.m[i][i] -= 1.0f;
        for (int j = 0; j < 3; ++j) squares += T.m[i][j] * T.m[i][j];
      }
      energy += 0.5 * simd::Sum(block.two_mu * squares + block.lambda * stretch * stretch);
      for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) T.m[i][j] *= block.two_mu;
        T.m[i][i] += block.lambda * stretch;
      }
      AddForces(T, state.RB, block, gradient);
    }
  }
  return energy;
}

double AddProduct(const ElementBlock* blocks, const ElementState* states, int count,
                  const simd::F4* p, simd::F4* y) {
  F8 curvature = F8{};
  for (int b = 0; b < count; ++b) {
    const ElementBlock& block = blocks[b];
    const ElementState& state = states[b];
    F8 e[3][3];
    Edges(p, block, e);
    Matrix8 A = Gradient(e, state.RB);
    const F8 a0 = A.m[2][1] - A.m[1][2], a1 = A.m[0][2] - A.m[2][0], a2 = A.m[1][0] - A.m[0][1];
    const F8* k = state.twist;
    const F8 w0 = k[0] * a0 + k[5] * a1 + k[4] * a2, w1 = k[5] * a0 + k[1] * a1 + k[3] * a2,
             w2 = k[4] * a0 + k[3] * a1 + k[2] * a2;
    const F8 trace = A.m[0][0] + A.m[1][1] + A.m[2][2];
    F8 squares = F8{};
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        squares += A.m[i][j] * A.m[i][j];
        A.m[i][j] *= block.two_mu;
      }
    const F8 pressure = block.lambda * trace;
    curvature += block.two_mu * squares + pressure * trace + w0 * a0 + w1 * a1 + w2 * a2;
    for (int i = 0; i < 3; ++i) A.m[i][i] += pressure;
    A.m[0][1] -= w2;
    A.m[1][0] += w2;
    A.m[0][2] += w1;
    A.m[2][0] -= w1;
    A.m[1][2] -= w0;
    A.m[2][1] += w0;
    AddForces(A, state.RB, block, y);
  }
  return static_cast<double>(simd::Sum(curvature));
}

}  // namespace kerf
