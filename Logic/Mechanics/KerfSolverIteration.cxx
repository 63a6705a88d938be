// The linear solves of KerfSolver: conjugate gradients with the two-level preconditioner.
#include <algorithm>
#include <cmath>
#include <limits>

#include "Mechanics/KerfSolver.h"

namespace kerf {
namespace {

using simd::F4;

/// Vertices out of balance by more than this, as the diagonal sees it and relative to the root of
/// the lowest ratio, are too far off for the tolerance of vertices.
constexpr double kOffMm = 0.025;
/// As many of them are a matter of a patch: they and those within two tetrahedra.
constexpr Index kMostOff = 40;
constexpr int kPatchRings = 2;
/// What a cut has freed is a patch of as many rings as are not more than this part of the mesh.
constexpr Index kLeastShare = 9;
/// Relative reduction of the energy norm of the residual per linear solve.
constexpr double kCgReduction = 0.003;
/// Of rᵀM⁻¹r: what is left then is rounding, whatever the goal.
constexpr double kNothingLeft = 1e-10;
/// Part of the energy's tolerance that a linear solve may leave, by the bound of its iteration;
/// less where it ends by its vertices: what the step's curvature adds is not to cost a second step.
constexpr double kGapPart = 0.25, kFineGapPart = 0.24;

/// A linear solve that leaves no vertex off by more than this, as M⁻¹r has it, has done enough for
/// the vertices: close to rest, rᵀM⁻¹r relative to the energy asks for far more.
constexpr double kFineMm = 0.0025;

/// The tridiagonal matrix of an iteration: it has the ends of the spectrum of M⁻¹H as its own.
void Tridiagonal(const std::vector<double>& alphas, const std::vector<double>& betas,
                 Eigen::VectorXd* diagonal, Eigen::VectorXd* off) {
  const Index m = static_cast<Index>(alphas.size());
  diagonal->resize(m);
  off->resize(m - 1);
  for (Index k = 0; k < m; ++k) {
    (*diagonal)[k] = 1.0 / alphas[k] + (k > 0 ? betas[k - 1] / alphas[k - 1] : 0.0);
    if (k + 1 < m) (*off)[k] = -std::sqrt(betas[k]) / alphas[k];
  }
}

/// Iterations that the spectrum is not told from.
constexpr Index kShortest = 3;
/// Below this the spectrum's lower end is not believed.
constexpr double kLeastRatio = 0.02;

/// Bound of eᵀHe of an iteration's error over its rᵀM⁻¹r (Gauss-Radau quadrature of its spectrum,
/// the lower end prescribed): far below 1 / lowest where little of the residual is soft.
double ErrorFactor(const std::vector<double>& alphas, const std::vector<double>& betas,
                   double lowest) {
  double factor = 1.0 / lowest;
  for (std::size_t k = 0; k < alphas.size(); ++k) {
    const double left = factor - alphas[k];
    if (!(left > 0.0)) return 1.0 / lowest;
    factor = left / (lowest * left + betas[k]);
  }
  return factor;
}

}  // namespace

double KerfSolver::GapAfter(const LinearSolve& solve, double start_nJ) const {
  const double overlap =
      workers_.SumChunks(field_.VertexCount(), VertexChunk(), [&](Index begin, Index end) {
        double sum = 0.0;
        for (Index v = begin; v < end; ++v)
          sum += static_cast<double>(
              simd::Dot3(simd::Load(solved_residual_[v]), simd::Load(direction_[v])));
        return sum;
      });
  const double other = std::max(0.0, start_nJ - 2.0 * overlap + solve.end_nJ);
  const double root = std::sqrt(solve.gap_nJ) + std::sqrt(kGapSafety * 0.5 * other / lowest_ratio_);
  return std::min(root * root, kGapSafety * 0.5 * start_nJ / lowest_ratio_);
}

double KerfSolver::Residual(double* largest_uN) {
  std::vector<float> largest(VertexChunks(), 0.0f);
  coarse_parts_.resize(VertexChunks());
  modes_.ReserveChunks(VertexChunks());
  const auto chunk = [&](Index begin, Index end) {
    for (Index v = begin; v < end; ++v) {
      const __m128 minus = _mm_set1_ps(-0.0f);
      const F4 anchor{anchor_[v] * static_cast<float>(x_[3 * v] - anchor_at_[3 * v]),
                      anchor_[v] * static_cast<float>(x_[3 * v + 1] - anchor_at_[3 * v + 1]),
                      anchor_[v] * static_cast<float>(x_[3 * v + 2] - anchor_at_[3 * v + 2]), 0.0f};
      simd::Store(&residual_[v],
                  _mm_xor_ps(minus, _mm_add_ps(field_.GradientAt(v), simd::Load(anchor))));
    }
    loads_.ForVertices(begin, end, [&](Index v, Index l, float w) {
      simd::Store(&residual_[v],
                  _mm_sub_ps(simd::Load(residual_[v]),
                             _mm_mul_ps(_mm_set1_ps(w), simd::Load(loads_.Loads()[l].gradient))));
    });
    float most = 0.0f;
    for (Index v = begin; v < end; ++v)
      most = std::max(
          {most, std::abs(residual_[v].x), std::abs(residual_[v].y), std::abs(residual_[v].z)});
    largest[begin / VertexChunk()] = most;
    return SmoothChunk(begin, end);
  };
  const double product = workers_.SumChunks(field_.VertexCount(), VertexChunk(), chunk);
  *largest_uN = static_cast<double>(*std::max_element(largest.begin(), largest.end()));
  return product + CorrectCoarse();
}

bool KerfSolver::FreeTip() {
  std::vector<Index> tip = std::move(tip_);
  tip_.clear();
  tip.erase(std::remove_if(tip.begin(), tip.end(), [&](Index v) { return field_.Outer(v) < 0; }),
            tip.end());
  std::sort(tip.begin(), tip.end());
  tip.erase(std::unique(tip.begin(), tip.end()), tip.end());
  if (tip.empty()) return false;
  std::vector<Index> patch;
  for (int rings = 1; rings <= kPatchRings; ++rings) {
    std::vector<Index> wider = field_.Surroundings(rings == 1 ? tip : patch, 1);
    if (kLeastShare * static_cast<Index>(wider.size()) > field_.VertexCount()) break;
    patch = std::move(wider);
  }
  if (patch.empty()) return false;
  patch_solver_.Solve(patch, {loads_, anchor_, anchor_at_, preconditioner_}, &field_, &x_);
  return true;
}

bool KerfSolver::CorrectPatch() {
  const double off2 = kOffMm * kOffMm * lowest_ratio_;
  std::vector<Index> off;
  for (Index v = 0; v < field_.VertexCount(); ++v) {
    const __m128 z = simd::Load(smooth_[v]);
    if (static_cast<double>(simd::Dot3(z, z)) > off2) off.push_back(v);
    if (static_cast<Index>(off.size()) > kMostOff) return false;
  }
  if (off.empty()) return false;
  const std::vector<Index> patch = field_.Surroundings(std::move(off), kPatchRings);
  if (2 * static_cast<Index>(patch.size()) > field_.VertexCount()) return false;
  patch_solver_.Solve(patch, {loads_, anchor_, anchor_at_, preconditioner_}, &field_, &x_);
  return true;
}

double KerfSolver::SmoothChunk(Index begin, Index end) {
  std::vector<F4>& sums = coarse_parts_[begin / VertexChunk()];
  sums.assign(preconditioner_.FunctionCount(), F4{});
  double sum = 0.0;
  for (Index v = begin; v < end; ++v) {
    const __m128 r = simd::Load(residual_[v]), z = preconditioner_.Smooth(v, r);
    simd::Store(&smooth_[v], z);
    sum += static_cast<double>(simd::Dot3(r, z));
    preconditioner_.Restrict(v, r, sums.data());
  }
  modes_.DotChunk(begin / VertexChunk(), begin, end, residual_.data());
  return sum;
}

double KerfSolver::CorrectCoarse() {
  const Index functions = preconditioner_.FunctionCount();
  coarse_residual_.assign(functions, F4{});
  for (const std::vector<F4>& part : coarse_parts_)
    for (Index f = 0; f < functions; ++f)
      simd::Store(&coarse_residual_[f],
                  _mm_add_ps(simd::Load(coarse_residual_[f]), simd::Load(part[f])));
  coarse_ = coarse_residual_;
  preconditioner_.SolveCoarse(coarse_.data());
  double product = modes_.Correct(VertexChunks());
  for (Index f = 0; f < functions; ++f)
    product +=
        static_cast<double>(simd::Dot3(simd::Load(coarse_residual_[f]), simd::Load(coarse_[f])));
  return product;
}

double KerfSolver::Direct(float beta, int iteration, double* farthest_mm) {
  std::vector<float> farthest(VertexChunks(), 0.0f);
  const __m128 b = _mm_set1_ps(beta);
  F4* record = was_cut_ ? modes_.Record(iteration, field_.VertexCount()) : nullptr;
  const double curvature =
      workers_.SumChunks(field_.VertexCount(), VertexChunk(), [&](Index begin, Index end) {
        double sum = 0.0;
        float most = 0.0f;
        for (Index v = begin; v < end; ++v) {
          const __m128 z = _mm_add_ps(_mm_add_ps(simd::Load(smooth_[v]), modes_.At(v)),
                                      preconditioner_.Prolong(v, coarse_.data()));
          if (record) simd::Store(&record[v], z);
          const __m128 p =
              beta == 0.0f ? z : _mm_add_ps(z, _mm_mul_ps(b, simd::Load(direction_[v])));
          simd::Store(&direction_[v], p);
          sum += static_cast<double>(anchor_[v] * simd::Dot3(p, p));
          most = std::max(most, simd::Dot3(z, z));
        }
        farthest[begin / VertexChunk()] = most;
        return sum;
      });
  const float most = farthest.empty() ? 0.0f : *std::max_element(farthest.begin(), farthest.end());
  *farthest_mm = std::sqrt(static_cast<double>(most));
  return curvature;
}

KerfSolver::LinearSolve KerfSolver::SolveLinear(double start_nJ, double anchor_curvature,
                                                const LinearGoal& goal) {
  LinearSolve solve;
  solve.start_nJ = solve.end_nJ = start_nJ;
  std::fill(step_.begin(), step_.end(), F4{});
  const Index chunks = static_cast<Index>(field_.Chunks().size());
  std::vector<double> alphas, betas, products;
  double rz = start_nJ, farthest = std::numeric_limits<double>::infinity();
  Eigen::VectorXd diagonal, off;
  Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> spectrum;
  // What the step gains, as its model has it, lowers the energy that the gap is relative to.
  double gained = 0.0;
  const double target = std::max(kCgReduction * kCgReduction * start_nJ, goal.enough_nJ);
  const auto measure = [&](int what) {
    double lowest = lowest_ratio_;
    if (static_cast<Index>(alphas.size()) >= kShortest) {
      Tridiagonal(alphas, betas, &diagonal, &off);
      spectrum.computeFromTridiagonal(diagonal, off, what);
      lowest = std::clamp(spectrum.eigenvalues()[0], kLeastRatio, 1.0);
    }
    solve.gap_nJ = 0.5 * rz * ErrorFactor(alphas, betas, lowest / kGapSafety);
    return lowest;
  };
  const auto enough = [&] {
    const bool by_vertices = rz > target;
    if (by_vertices && farthest > kFineMm * std::sqrt(lowest_ratio_)) return false;
    measure(Eigen::EigenvaluesOnly);
    return solve.gap_nJ <=
           (by_vertices ? kFineGapPart : kGapPart) *
               (goal.tolerance * std::max(0.0, goal.energy_nJ - gained) + goal.floor_nJ);
  };
  while (solve.iterations < goal.most_iterations && rz > kNothingLeft * start_nJ) {
    // Chunk `chunks` stands for the springs.
    const double curvature =
        anchor_curvature + workers_.SumChunks(chunks + 1, 1, [&](Index c, Index) {
          return c < chunks ? field_.MultiplyChunk(c, direction_.data())
                            : loads_.Multiply(direction_.data());
        });
    if (!(curvature > 0.0)) break;
    const double alpha = rz / curvature;
    const __m128 a = _mm_set1_ps(static_cast<float>(alpha));
    const auto update = [&](Index begin, Index end) {
      for (Index v = begin; v < end; ++v) {
        const __m128 p = simd::Load(direction_[v]);
        const __m128 q = _mm_add_ps(field_.ProductAt(v), _mm_mul_ps(_mm_set1_ps(anchor_[v]), p));
        simd::Store(&residual_[v], _mm_sub_ps(simd::Load(residual_[v]), _mm_mul_ps(a, q)));
        simd::Store(&step_[v], _mm_add_ps(simd::Load(step_[v]), _mm_mul_ps(a, p)));
      }
      loads_.ForVertices(begin, end, [&](Index v, Index l, float w) {
        simd::Store(&residual_[v], _mm_sub_ps(simd::Load(residual_[v]),
                                              _mm_mul_ps(_mm_mul_ps(a, _mm_set1_ps(w)),
                                                         simd::Load(loads_.Products()[l]))));
      });
      return SmoothChunk(begin, end);
    };
    const double smoothed = workers_.SumChunks(field_.VertexCount(), VertexChunk(), update);
    const double next = smoothed + CorrectCoarse();
    const double beta = next / rz;
    alphas.push_back(alpha);
    products.push_back(rz);
    betas.push_back(beta);
    gained += 0.5 * alpha * rz;
    rz = next;
    ++solve.iterations;
    if (enough()) break;
    anchor_curvature = Direct(static_cast<float>(beta), solve.iterations, &farthest);
  }
  solve.end_nJ = rz;
  lowest_ratio_ = measure(was_cut_ ? Eigen::ComputeEigenvectors : Eigen::EigenvaluesOnly);
  if (was_cut_ && static_cast<Index>(alphas.size()) >= kShortest)
    modes_.Learn(workers_, field_.VertexCount(), spectrum.eigenvalues(), spectrum.eigenvectors(),
                 products);
  return solve;
}

}  // namespace kerf
