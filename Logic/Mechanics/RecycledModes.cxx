#include "Mechanics/RecycledModes.h"

#include <cmath>

namespace kerf {
namespace {

/// Modes are few: each costs a dot product and an update in every iteration.
constexpr std::size_t kMostModes = 4;
constexpr int kMostPerSolve = 2, kMostRecords = 16;
/// Only what is softer than this slows the iteration down.
constexpr double kSoft = 0.25;
/// Ritz vectors of a shorter iteration are not worth keeping.
constexpr Index kShortest = 6;
constexpr Index kVertexChunk = 1024;

}  // namespace

void RecycledModes::Clear() {
  modes_.clear();
  dots_.clear();
}

void RecycledModes::Apply(const ElementField& field, const TopologyChange& change,
                          const ElementField::Patch& patch) {
  std::vector<simd::F4> at(patch.new_vertices.size());
  for (Mode& mode : modes_) {
    for (std::size_t i = 0; i < at.size(); ++i) {
      const Index outer = field.Outer(patch.new_vertices[i]);
      __m128 sum = _mm_setzero_ps();
      for (int k = 0; k < 4; ++k)
        sum = _mm_add_ps(
            sum, _mm_mul_ps(_mm_set1_ps(static_cast<float>(change.vertex_weights(outer, k))),
                            simd::Load(mode.motion[patch.parents[i][k]])));
      simd::Store(&at[i], sum);
    }
    mode.motion.resize(field.VertexCount());
    for (std::size_t i = 0; i < at.size(); ++i) mode.motion[patch.new_vertices[i]] = at[i];
  }
}

simd::F4* RecycledModes::Record(int iteration, Index vertices) {
  if (iteration >= kMostRecords) return nullptr;
  if (static_cast<int>(records_.size()) <= iteration) records_.resize(iteration + 1);
  records_[iteration].resize(vertices);
  return records_[iteration].data();
}

void RecycledModes::Learn(const Workers& workers, Index vertices, const Eigen::VectorXd& values,
                          const Eigen::MatrixXd& vectors, const std::vector<double>& products) {
  const Index terms = std::min<Index>(static_cast<Index>(products.size()), kMostRecords);
  if (values.size() < kShortest) return;
  for (int q = 0; q < kMostPerSolve && values[q] < kSoft; ++q) {
    Mode mode;
    mode.motion.resize(vertices);
    mode.stiffness = std::max(values[q], 1e-3);
    workers.ForChunks(vertices, kVertexChunk, [&](Index begin, Index end) {
      for (Index k = 0; k < terms; ++k) {
        const __m128 factor =
            _mm_set1_ps(static_cast<float>(vectors(k, q) / std::sqrt(products[k])));
        const simd::F4* record = records_[k].data();
        for (Index v = begin; v < end; ++v)
          simd::Store(&mode.motion[v], _mm_add_ps(simd::Load(mode.motion[v]),
                                                  _mm_mul_ps(factor, simd::Load(record[v]))));
      }
    });
    if (modes_.size() == kMostModes) modes_.erase(modes_.begin());
    modes_.push_back(std::move(mode));
  }
}

void RecycledModes::DotChunk(Index chunk, Index begin, Index end, const simd::F4* residual) {
  for (std::size_t m = 0; m < modes_.size(); ++m) {
    __m128 dot = _mm_setzero_ps();
    for (Index v = begin; v < end; ++v)
      dot = _mm_add_ps(dot, _mm_mul_ps(simd::Load(residual[v]), simd::Load(modes_[m].motion[v])));
    dots_[chunk * modes_.size() + m] = simd::Dot3(dot, _mm_set1_ps(1.0f));
  }
}

double RecycledModes::Correct(Index chunks) {
  double product = 0.0;
  for (std::size_t m = 0; m < modes_.size(); ++m) {
    double dot = 0.0;
    for (Index c = 0; c < chunks; ++c) dot += static_cast<double>(dots_[c * modes_.size() + m]);
    modes_[m].amount = static_cast<float>(dot / modes_[m].stiffness);
    product += dot * dot / modes_[m].stiffness;
  }
  return product;
}

}  // namespace kerf
