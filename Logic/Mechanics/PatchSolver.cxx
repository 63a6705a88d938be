#include "Mechanics/PatchSolver.h"

#include <algorithm>
#include <cmath>

namespace kerf {
namespace {

using simd::F4;

constexpr int kMaxNewtonSteps = 2, kMaxCgIterations = 40, kMaxHalvings = 4;
/// Reduction of the residual by a linear solve, in the norm of the preconditioner.
constexpr double kCgReduction = 0.2;
/// A step whose longest motion is shorter was the last one.
constexpr float kSmallMm = 0.01f;

double Dot(const std::vector<F4>& a, const std::vector<F4>& b, Index count) {
  double sum = 0.0;
  for (Index i = 0; i < count; ++i)
    sum += static_cast<double>(simd::Dot3(simd::Load(a[i]), simd::Load(b[i])));
  return sum;
}

/// y += factor x
void AddScaled(float factor, const std::vector<F4>& x, Index count, std::vector<F4>* y) {
  const __m128 f = _mm_set1_ps(factor);
  for (Index i = 0; i < count; ++i)
    simd::Store(&(*y)[i], _mm_add_ps(simd::Load((*y)[i]), _mm_mul_ps(f, simd::Load(x[i]))));
}

}  // namespace

void PatchSolver::Attach(const Problem& problem) {
  pulls_.clear();
  pulled_.clear();
  for (Index i = 0; i < free_; ++i)
    problem.loads.ForVertices(excerpt_.vertices[i], excerpt_.vertices[i] + 1,
                              [&](Index, Index load, float weight) {
                                pulls_.push_back({i, load, weight});
                                pulled_.push_back(load);
                              });
  std::sort(pulled_.begin(), pulled_.end());
  pulled_.erase(std::unique(pulled_.begin(), pulled_.end()), pulled_.end());
  for (Pull& pull : pulls_)
    pull.load = static_cast<Index>(std::lower_bound(pulled_.begin(), pulled_.end(), pull.load) -
                                   pulled_.begin());
}

void PatchSolver::SetForce(const Problem& problem, const std::vector<double>& x) {
  for (Index i = 0; i < free_; ++i) {
    const Index v = excerpt_.vertices[i];
    float pull[3];
    for (int k = 0; k < 3; ++k)
      pull[k] = problem.anchor[v] * static_cast<float>(problem.anchor_at[3 * v + k] - x[3 * v + k]);
    force_[i] = {pull[0], pull[1], pull[2], 0.0f};
  }
  for (const Pull& pull : pulls_) {
    const F4& gradient = problem.loads.Loads()[pulled_[pull.load]].gradient;
    simd::Store(&force_[pull.free],
                _mm_sub_ps(simd::Load(force_[pull.free]),
                           _mm_mul_ps(_mm_set1_ps(pull.weight), simd::Load(gradient))));
  }
}

void PatchSolver::AddOuterProduct(const Problem& problem, const std::vector<F4>& p,
                                  std::vector<F4>* y) {
  pulled_values_.assign(pulled_.size(), F4{});
  const auto add = [](float w, const F4& value, F4* sum) {
    simd::Store(sum, _mm_add_ps(simd::Load(*sum), _mm_mul_ps(_mm_set1_ps(w), simd::Load(value))));
  };
  for (const Pull& pull : pulls_) add(pull.weight, p[pull.free], &pulled_values_[pull.load]);
  for (std::size_t l = 0; l < pulled_.size(); ++l)
    pulled_values_[l] = problem.loads.Loads()[pulled_[l]].Times(pulled_values_[l]);
  for (const Pull& pull : pulls_) add(pull.weight, pulled_values_[pull.load], &(*y)[pull.free]);
  for (Index i = 0; i < free_; ++i) add(problem.anchor[excerpt_.vertices[i]], p[i], &(*y)[i]);
}

double PatchSolver::Linearize(const Problem& problem) {
  product_.assign(excerpt_.vertices.size(), F4{});
  const double elastic =
      kerf::Linearize(excerpt_.blocks.data(), excerpt_.states.data(),
                      static_cast<int>(excerpt_.blocks.size()), x_.data(), product_.data());
  // With d the motion so far and K_o springs and anchors, E = W_I − f·d + ½ dᵀ K_o d.
  for (Index i = 0; i < free_; ++i)
    simd::Store(&local_[i], _mm_sub_ps(simd::Load(x_[i]), simd::Load(start_[i])));
  outer_.assign(free_, F4{});
  AddOuterProduct(problem, local_, &outer_);
  const double energy = elastic - Dot(force_, local_, free_) + 0.5 * Dot(outer_, local_, free_);
  for (Index i = 0; i < free_; ++i)
    simd::Store(&residual_[i], _mm_sub_ps(_mm_sub_ps(simd::Load(force_[i]), simd::Load(outer_[i])),
                                          simd::Load(product_[i])));
  return energy;
}

double PatchSolver::SolveLinear(const Problem& problem) {
  std::vector<F4> r = residual_;
  step_.assign(free_, F4{});
  std::fill(local_.begin(), local_.end(), F4{});  // the direction; nothing moves around the patch
  double rz = 0.0, start = 0.0, beta = 0.0;
  for (int iteration = 0; iteration <= kMaxCgIterations; ++iteration) {
    double next = 0.0;
    for (Index i = 0; i < free_; ++i) {
      const __m128 at = simd::Load(r[i]);
      const __m128 z = problem.preconditioner.Smooth(excerpt_.vertices[i], at);
      next += static_cast<double>(simd::Dot3(at, z));
      simd::Store(&direction_[i], z);
    }
    if (iteration == 0)
      start = next;
    else
      beta = next / rz;
    rz = next;
    if (!(rz > kCgReduction * kCgReduction * start) || iteration == kMaxCgIterations) break;
    AddScaled(static_cast<float>(beta), local_, free_, &direction_);
    std::copy(direction_.begin(), direction_.end(), local_.begin());
    product_.assign(excerpt_.vertices.size(), F4{});
    AddProduct(excerpt_.blocks.data(), excerpt_.states.data(),
               static_cast<int>(excerpt_.blocks.size()), local_.data(), product_.data());
    AddOuterProduct(problem, local_, &product_);
    const double curvature = Dot(local_, product_, free_);
    if (!(curvature > 0.0)) break;
    const float alpha = static_cast<float>(rz / curvature);
    AddScaled(alpha, local_, free_, &step_);
    AddScaled(-alpha, product_, free_, &r);
  }
  return Dot(residual_, step_, free_);
}

void PatchSolver::Solve(const std::vector<Index>& vertices, const Problem& problem,
                        ElementField* field, std::vector<double>* x) {
  field->Extract(vertices, &excerpt_);
  free_ = static_cast<Index>(vertices.size());
  Attach(problem);
  const std::size_t count = excerpt_.vertices.size();
  x_.resize(count);
  local_.assign(count, F4{});
  for (std::size_t i = 0; i < count; ++i) {
    const double* at = &(*x)[3 * excerpt_.vertices[i]];
    x_[i] = {static_cast<float>(at[0]), static_cast<float>(at[1]), static_cast<float>(at[2]), 0.0f};
  }
  start_.assign(x_.begin(), x_.begin() + free_);
  force_.resize(free_);
  residual_.resize(free_);
  direction_.resize(free_);
  SetForce(problem, *x);
  double energy = Linearize(problem);
  for (int newton = 0; newton < kMaxNewtonSteps; ++newton) {
    const double descent = SolveLinear(problem);
    float longest = 0.0f;
    for (const F4& s : step_) longest = std::max(longest, simd::Dot3(simd::Load(s), simd::Load(s)));
    bool accepted = false;
    float length = 1.0f;
    AddScaled(1.0f, step_, free_, &x_);
    for (int halving = 0; halving <= kMaxHalvings; ++halving) {
      const double trial = Linearize(problem);
      accepted = trial <= energy - 0.1 * static_cast<double>(length) * descent;
      if (accepted) {
        energy = trial;
        break;
      }
      length *= 0.5f;
      AddScaled(-length, step_, free_, &x_);
    }
    if (!accepted) {
      AddScaled(-length, step_, free_, &x_);
      break;
    }
    if (longest <= kSmallMm * kSmallMm) break;
  }
  for (Index i = 0; i < free_; ++i) {
    double* at = &(*x)[3 * excerpt_.vertices[i]];
    at[0] += static_cast<double>(x_[i].x - start_[i].x);
    at[1] += static_cast<double>(x_[i].y - start_[i].y);
    at[2] += static_cast<double>(x_[i].z - start_[i].z);
  }
  field->MarkStale(excerpt_.chunks);
}

}  // namespace kerf
