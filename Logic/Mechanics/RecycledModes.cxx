#include "Mechanics/RecycledModes.h"

#include <cmath>

namespace kerf {
namespace {

constexpr int kMostPerSolve = 2, kMostRecords = 16;
/// Only what is softer than this slows the iteration down.
constexpr double kSoft = 0.25;
/// Ritz vectors of a shorter iteration are not worth keeping.
constexpr Index kShortest = 6;
constexpr Index kVertexChunk = 256;

}  // namespace

void RecycledModes::Clear() {
  count_ = next_ = 0;
  motion_.clear();
}

void RecycledModes::Reserve(Index vertices) {
  motion_.assign(vertices * kModes, {});
  records_.resize(kMostRecords);
  for (std::vector<simd::F4>& record : records_) record.assign(vertices, {});
}

void RecycledModes::Apply(const ElementField& field, const TopologyChange& change,
                          const ElementField::Patch& patch) {
  if (count_ == 0) return;
  std::vector<simd::F4> at(patch.new_vertices.size() * kModes);
  for (std::size_t i = 0; i < patch.new_vertices.size(); ++i) {
    const Index outer = field.Outer(patch.new_vertices[i]);
    for (Index m = 0; m < count_; ++m) {
      __m128 sum = _mm_setzero_ps();
      for (int k = 0; k < 4; ++k)
        sum = _mm_add_ps(
            sum, _mm_mul_ps(_mm_set1_ps(static_cast<float>(change.vertex_weights(outer, k))),
                            simd::Load(motion_[patch.parents[i][k] * kModes + m])));
      simd::Store(&at[i * kModes + m], sum);
    }
  }
  motion_.resize(field.VertexCount() * kModes);
  for (std::size_t i = 0; i < patch.new_vertices.size(); ++i)
    std::copy_n(at.begin() + i * kModes, kModes, motion_.begin() + patch.new_vertices[i] * kModes);
}

simd::F4* RecycledModes::Record(int iteration, Index vertices) {
  if (iteration >= kMostRecords) return nullptr;
  records_.resize(kMostRecords);
  records_[iteration].resize(vertices);
  return records_[iteration].data();
}

void RecycledModes::Learn(const Workers& workers, Index vertices, const Eigen::VectorXd& values,
                          const Eigen::MatrixXd& vectors, const std::vector<double>& products) {
  const Index terms = std::min<Index>(static_cast<Index>(products.size()), kMostRecords);
  if (values.size() < kShortest) return;
  std::vector<float> factors(terms);
  for (int q = 0; q < kMostPerSolve && values[q] < kSoft; ++q) {
    for (Index k = 0; k < terms; ++k)
      factors[k] = static_cast<float>(vectors(k, q) / std::sqrt(products[k]));
    const Index m = next_;
    next_ = (next_ + 1) % kModes;
    count_ = std::max(count_, m + 1);
    stiffness_[m] = std::max(values[q], 1e-3);
    motion_.resize(vertices * kModes);
    workers.ForChunks(vertices, kVertexChunk, [&](Index begin, Index end) {
      for (Index v = begin; v < end; ++v) {
        __m128 sum = _mm_setzero_ps();
        for (Index k = 0; k < terms; ++k)
          sum = _mm_add_ps(sum, _mm_mul_ps(_mm_set1_ps(factors[k]), simd::Load(records_[k][v])));
        simd::Store(&motion_[v * kModes + m], sum);
      }
    });
  }
}

void RecycledModes::DotChunk(Index chunk, Index begin, Index end, const simd::F4* residual) {
  if (count_ == 0) return;
  __m128 dots[kModes] = {};
  for (Index v = begin; v < end; ++v) {
    const __m128 r = simd::Load(residual[v]);
    for (Index m = 0; m < kModes; ++m)
      dots[m] = _mm_add_ps(dots[m], _mm_mul_ps(r, simd::Load(motion_[v * kModes + m])));
  }
  for (Index m = 0; m < kModes; ++m)
    dots_[chunk * kModes + m] = simd::Dot3(dots[m], _mm_set1_ps(1.0f));
}

double RecycledModes::Correct(Index chunks) {
  double product = 0.0;
  for (Index m = 0; m < count_; ++m) {
    double dot = 0.0;
    for (Index c = 0; c < chunks; ++c) dot += static_cast<double>(dots_[c * kModes + m]);
    amount_[m] = static_cast<float>(dot / stiffness_[m]);
    product += dot * dot / stiffness_[m];
  }
  return product;
}

}  // namespace kerf
