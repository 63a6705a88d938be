#include "Adapters/OpenCv/PatchAligner.h"

#include <immintrin.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace kerf {
namespace {

/// Least share of a patch that has to be usable, in the reference as in the current frame.
constexpr float kLeastUsed = 0.45F;
/// Least texture: a smaller eigenvalue below this is camera noise.
constexpr float kLeastTexture = 1.0F;

bool IsPlausible(const Eigen::Matrix2f& A) {
  // Singular values of a 2×2 matrix from its invariants; tissue stretches, it does not mirror or
  // collapse.
  const float determinant = A.determinant();
  const float squares = A.squaredNorm();
  if (!(determinant > 0.08F) || !(squares < 12.0F)) return false;
  const float root = std::sqrt(std::max(0.0F, squares * squares - 4 * determinant * determinant));
  const float largest = std::sqrt(0.5F * (squares + root));
  return largest < 3.2F && determinant / largest > 0.25F;
}

/// Eight values and their right neighbours. A gather fetches them one by one, these are loads of
/// two.
void LoadPairs(const float* base, const std::int32_t* place, __m256* left, __m256* right) {
  const auto two = [&](int k) {
    const __m128 first =
        _mm_loadl_pi(_mm_setzero_ps(), reinterpret_cast<const __m64*>(base + place[k]));
    return _mm_loadh_pi(first, reinterpret_cast<const __m64*>(base + place[k + 1]));
  };
  const __m256 even = _mm256_set_m128(two(4), two(0)), odd = _mm256_set_m128(two(6), two(2));
  *left = _mm256_shuffle_ps(even, odd, 0x88);
  *right = _mm256_shuffle_ps(even, odd, 0xDD);
}

/// `count` bilinear samples along a line, eight at a time. One instruction set for the whole
/// program: the bits do not depend on the machine.
void SampleRow(const float* base, int stride, float u, float v, float du, float dv, int count,
               float* out) {
  const __m256 steps = _mm256_setr_ps(0, 1, 2, 3, 4, 5, 6, 7);
  for (int i = 0; i < count; i += 8) {
    // The last group starts earlier instead of running over the row's end.
    const int first = std::max(0, std::min(i, count - 8));
    const __m256 k = _mm256_add_ps(_mm256_set1_ps(static_cast<float>(first)), steps);
    const __m256 x = _mm256_fmadd_ps(k, _mm256_set1_ps(du), _mm256_set1_ps(u));
    const __m256 y = _mm256_fmadd_ps(k, _mm256_set1_ps(dv), _mm256_set1_ps(v));
    const __m256i ix = _mm256_cvttps_epi32(x), iy = _mm256_cvttps_epi32(y);
    const __m256 fx = _mm256_sub_ps(x, _mm256_cvtepi32_ps(ix));
    const __m256 fy = _mm256_sub_ps(y, _mm256_cvtepi32_ps(iy));
    const __m256i at = _mm256_add_epi32(_mm256_mullo_epi32(iy, _mm256_set1_epi32(stride)), ix);
    alignas(32) std::int32_t place[8];
    _mm256_store_si256(reinterpret_cast<__m256i*>(place), at);
    __m256 p00, p10, p01, p11;
    LoadPairs(base, place, &p00, &p10);
    LoadPairs(base + stride, place, &p01, &p11);
    const __m256 top = _mm256_fmadd_ps(fx, _mm256_sub_ps(p10, p00), p00);
    const __m256 bottom = _mm256_fmadd_ps(fx, _mm256_sub_ps(p11, p01), p01);
    _mm256_storeu_ps(out + first, _mm256_fmadd_ps(fy, _mm256_sub_ps(bottom, top), top));
  }
}

}  // namespace

/// What a correlation needs of the reference.
struct Patch::Appearance {
  Eigen::VectorXf centered, weighted_values;  ///< T − mean, w · (T − mean)
  Eigen::VectorXf weights;
  float weight_sum = 0, energy = 0;  ///< Σ w, Σ w (T − mean)²
};

/// Columns: moves along u and v, then the four entries of A over coordinates scaled to ±1.
struct Patch::System : Patch::Appearance {
  Eigen::Matrix<float, Eigen::Dynamic, 6>
      descent;  ///< w · steepest descent, free of gain and offset
  Eigen::Matrix<float, 6, 6> inverse_hessian;
};

bool Patch::Sample(const cv::Mat& grey, const AffineWarp& warp, Eigen::VectorXf* values) const {
  const int side = 2 * half_ + 1;
  const float h = static_cast<float>(half_);
  // All four corners inside means all inside: the warp is affine.
  for (const float x : {-h, h})
    for (const float y : {-h, h}) {
      const Eigen::Vector2f p = warp.A * Eigen::Vector2f(x, y) + warp.t;
      if (!(p.x() >= 0 && p.y() >= 0 && p.x() < grey.cols - 1.01F && p.y() < grey.rows - 1.01F))
        return false;
    }
  values->resize(side * side);
  const int stride = static_cast<int>(grey.step / sizeof(float));
  const float* base = grey.ptr<float>();
  const float dx = warp.A(0, 0), dy = warp.A(1, 0);
  for (int j = 0; j < side; ++j) {
    const Eigen::Vector2f start = warp.A * Eigen::Vector2f(-h, static_cast<float>(j) - h) + warp.t;
    SampleRow(base, stride, start.x(), start.y(), dx, dy, side, values->data() + j * side);
  }
  return true;
}

float Patch::UsableWeights(const cv::Mat& excluded, const AffineWarp& warp,
                           Eigen::VectorXf* weights) const {
  *weights = weights_;
  if (excluded.empty()) return 1.0F;
  const int side = 2 * half_ + 1;
  float* out = weights->data();
  float lost = 0;
  for (int j = 0; j < side; ++j)
    for (int i = 0; i < side; ++i, ++out) {
      const Eigen::Vector2f p =
          warp.A * Eigen::Vector2f(static_cast<float>(i - half_), static_cast<float>(j - half_)) +
          warp.t;
      const int u = static_cast<int>(p.x() + 0.5F), v = static_cast<int>(p.y() + 0.5F);
      if (u < 0 || v < 0 || u >= excluded.cols || v >= excluded.rows ||
          excluded.at<std::uint8_t>(v, u) != 0) {
        lost += *out;
        *out = 0;
      }
    }
  return 1.0F - lost / weights_.sum();
}

bool Patch::MakeAppearance(const Eigen::VectorXf& weights, Appearance* out) const {
  out->weights = weights;
  out->weight_sum = weights.sum();
  const float mean = weights.dot(values_) / out->weight_sum;
  out->centered = values_.array() - mean;
  out->weighted_values = weights.cwiseProduct(out->centered);
  out->energy = out->weighted_values.dot(out->centered);
  return out->energy > 1e-3F;
}

std::shared_ptr<const Patch::System> Patch::MakeSystem(const Eigen::VectorXf& weights) const {
  auto system = std::make_shared<System>();
  if (!MakeAppearance(weights, system.get())) return nullptr;
  const Eigen::VectorXf& centered = system->centered;
  const int side = 2 * half_ + 1;
  Eigen::Matrix<float, Eigen::Dynamic, 6> descent(values_.size(), 6);
  for (int j = 0, k = 0; j < side; ++j)
    for (int i = 0; i < side; ++i, ++k) {
      const float x = static_cast<float>(i - half_) / static_cast<float>(half_);
      const float y = static_cast<float>(j - half_) / static_cast<float>(half_);
      const float gx = gradient_x_[k], gy = gradient_y_[k];
      descent.row(k) << gx, gy, gx * x, gx * y, gy * x, gy * y;
    }
  // What a gain or an offset of the brightness explains is no evidence of motion.
  for (int c = 0; c < 6; ++c) {
    descent.col(c).array() -= weights.dot(descent.col(c)) / system->weight_sum;
    descent.col(c) -= (system->weighted_values.dot(descent.col(c)) / system->energy) * centered;
  }
  system->descent = weights.asDiagonal() * descent;
  Eigen::Matrix<float, 6, 6> hessian = system->descent.transpose() * descent;
  // Damps the shape where the texture does not show it; the position is left free.
  const float damping = 0.02F * (hessian(0, 0) + hessian(1, 1));
  for (int c = 2; c < 6; ++c) hessian(c, c) += damping;
  if (!(hessian.topLeftCorner<2, 2>().determinant() > 1e-6F)) return nullptr;
  system->inverse_hessian = hessian.cast<double>().inverse().cast<float>();
  if (!system->inverse_hessian.allFinite()) return nullptr;
  return system;
}

bool Patch::Take(const cv::Mat& grey, const cv::Mat& excluded, const Eigen::Vector2f& center,
                 int half_px) {
  system_ = nullptr;
  half_ = half_px;
  AffineWarp warp;
  warp.t = center;
  if (!Sample(grey, warp, &values_)) return false;
  // Central differences of the sampled image: the gradient of what is compared later.
  Eigen::VectorXf shifted;
  const auto derivative = [&](const Eigen::Vector2f& step, Eigen::VectorXf* out) {
    AffineWarp moved = warp;
    moved.t = center + step;
    if (!Sample(grey, moved, out)) return false;
    moved.t = center - step;
    if (!Sample(grey, moved, &shifted)) return false;
    *out = 0.5F * (*out - shifted);
    return true;
  };
  if (!derivative({1, 0}, &gradient_x_) || !derivative({0, 1}, &gradient_y_)) return false;

  const int side = 2 * half_ + 1;
  weights_.resize(side * side);
  const float spread = 0.6F * static_cast<float>(half_);
  for (int j = 0, k = 0; j < side; ++j)
    for (int i = 0; i < side; ++i, ++k) {
      const float x = static_cast<float>(i - half_), y = static_cast<float>(j - half_);
      weights_[k] = std::exp(-0.5F * (x * x + y * y) / (spread * spread));
    }
  Eigen::VectorXf usable;
  if (UsableWeights(excluded, warp, &usable) < kLeastUsed) return false;
  weights_ = usable;
  const float xx = weights_.dot(gradient_x_.cwiseAbs2()),
              yy = weights_.dot(gradient_y_.cwiseAbs2());
  const float xy = weights_.dot(gradient_x_.cwiseProduct(gradient_y_));
  const float sum = weights_.sum();
  texture_ = (0.5F * (xx + yy) - std::sqrt(0.25F * (xx - yy) * (xx - yy) + xy * xy)) / sum;
  if (!(texture_ > kLeastTexture)) return false;
  system_ = MakeSystem(weights_);
  return system_ != nullptr;
}

Alignment Patch::Align(const cv::Mat& grey, const cv::Mat& excluded, int iterations,
                       AffineWarp* warp) const {
  Alignment result;
  if (Empty() || !IsPlausible(warp->A)) return result;
  static thread_local Eigen::VectorXf weights, values;
  result.used = excluded.empty() ? 1.0F : UsableWeights(excluded, *warp, &weights);
  if (result.used < kLeastUsed) return result;
  // `common` = Σ w (T − mean) I, of the values as they are.
  const auto correlate = [](const Appearance& of, float* common) {
    *common = of.weighted_values.dot(values);
    const float mean = of.weights.dot(values) / of.weight_sum;
    const float energy = (of.weights.array() * (values.array() - mean).square()).sum();
    return energy > 1e-6F ? *common / std::sqrt(of.energy * energy) : 0.0F;
  };
  std::shared_ptr<const System> own;
  if (result.used < 0.995F) {
    if (iterations == 0) {  // only asked how alike they are
      static thread_local Appearance masked;
      float common = 0;
      result.valid = MakeAppearance(weights, &masked) && Sample(grey, *warp, &values);
      if (result.valid) result.correlation = correlate(masked, &common);
      return result;
    }
    own = MakeSystem(weights);
    if (!own) return result;
  }
  const System& system = own ? *own : *system_;
  const float scale = 1.0F / static_cast<float>(half_);
  for (int iteration = 0;; ++iteration) {
    if (!Sample(grey, *warp, &values)) return result;
    float common = 0;
    result.correlation = correlate(system, &common);
    if (iteration == iterations) break;
    const float gain = common / system.energy;
    if (!(gain > 0.05F)) return result;
    const Eigen::Matrix<float, 6, 1> step =
        system.inverse_hessian * (system.descent.transpose() * values) / gain;
    if (!step.allFinite()) return result;
    // Inverse composition: what moves the reference onto the image moves the warp the other way.
    Eigen::Matrix2f increment;
    increment << 1 + step[2] * scale, step[3] * scale, step[4] * scale, 1 + step[5] * scale;
    if (!(increment.determinant() > 0.1F)) return result;
    warp->A = warp->A * increment.inverse();
    warp->t -= warp->A * step.head<2>();
    if (!IsPlausible(warp->A)) return result;
    if (step.head<2>().squaredNorm() < 1e-4F && iteration + 1 < iterations)
      iterations = iteration + 1;
  }
  result.valid = true;
  return result;
}

}  // namespace kerf
