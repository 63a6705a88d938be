#include "Mechanics/BandCholesky.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace kerf {

using simd::F8;

void BandCholesky::SetProfile(std::vector<Index> first_block, Index room) {
  first_ = std::move(first_block);
  offset_.assign(1, 0);
  for (Index i = 0; i < Blocks(); ++i) offset_.push_back(offset_[i] + i - first_[i] + 1);
  const std::size_t size = 8 * static_cast<std::size_t>(offset_.back() + room * (Blocks() + room));
  for (std::vector<F8>* blocks : {&matrix_, &factor_}) {
    blocks->clear();
    blocks->reserve(size);
  }
  matrix_.resize(8 * static_cast<std::size_t>(offset_.back()), F8{});
}

void BandCholesky::Append(Index block_rows, Index first_block) {
  for (Index row = 0; row < block_rows; ++row) {
    first_.push_back(first_block);
    offset_.push_back(offset_.back() + Blocks() - first_block);
  }
  matrix_.resize(8 * static_cast<std::size_t>(offset_.back()), F8{});
}

void BandCholesky::AddBlock(Index row, Index column, const float block[9]) {
  const bool lower = row >= column;
  const Index low = lower ? column : row, high = lower ? row : column;
  for (Index r = 0; r < 3; ++r) {
    const Index i = (high + r) / 8, lane = (high + r) % 8;
    F8* columns = &matrix_[8 * static_cast<std::size_t>(offset_[i] - first_[i]) + low];
    const Index count = row == column ? r + 1 : 3;
    for (Index c = 0; c < count; ++c)
      columns[c][lane] += lower ? block[3 * r + c] : block[3 * c + r];
  }
}

float BandCholesky::Factor(Index from_block) {
  const Index blocks = Blocks();
  constexpr float kLost = 1e-5f;  // of a unit diagonal: below this a pivot is rounding
  float smallest = 1.0f;
  scale_.resize(8 * static_cast<std::size_t>(blocks));
  for (Index row = 8 * from_block; row < 8 * blocks; ++row) {
    const Index i = row / 8;
    const float diagonal = matrix_[8 * offset_[i] + row - 8 * first_[i]][row % 8];
    scale_[row] = diagonal > 0.0f ? 1.0f / std::sqrt(diagonal) : 0.0f;
  }
  factor_.resize(matrix_.size());
  inverse_.resize(8 * static_cast<std::size_t>(blocks));
  inverse_transposed_.resize(inverse_.size());
  std::fill(inverse_.begin() + 8 * from_block, inverse_.end(), F8{});
  for (Index i = from_block; i < blocks; ++i) {
    F8 row_scale;
    for (int r = 0; r < 8; ++r) row_scale[r] = scale_[8 * i + r];
    F8* row = factor_.data() + 8 * static_cast<std::size_t>(offset_[i]);  // column 0 = 8·first_[i]
    for (Index j = first_[i]; j <= i; ++j) {
      const F8* other = factor_.data() + 8 * static_cast<std::size_t>(offset_[j]);
      F8 sum[8];
      for (int c = 0; c < 8; ++c)
        sum[c] = matrix_[8 * static_cast<std::size_t>(offset_[i] + j - first_[i]) + c] * row_scale *
                 scale_[8 * j + c];
      const Index from = 8 * std::max(first_[i], first_[j]), to = 8 * j;
      const F8* a = row + (from - 8 * first_[i]);
      const F8* b = other + (from - 8 * first_[j]);
      for (Index k = from; k < to; ++k, ++a, ++b)
        for (int c = 0; c < 8; ++c) sum[c] -= *a * (*b)[c];
      F8* target = row + 8 * (j - first_[i]);
      if (j < i) {
        // X L_jjᵀ = S, by the inverse of the diagonal block: X = S L_jj⁻ᵀ.
        for (int c = 0; c < 8; ++c) {
          F8 x = F8{};
          for (int k = 0; k <= c; ++k) x += sum[k] * inverse_[8 * j + k][c];
          target[c] = x;
        }
        continue;
      }
      // Dense Cholesky of the diagonal block; lost pivots drop their unknown.
      for (int c = 0; c < 8; ++c) {
        for (int k = 0; k < c; ++k) sum[c] -= sum[k] * sum[k][c];
        const float pivot = sum[c][c];
        if (scale_[8 * i + c] > 0.0f) smallest = std::min(smallest, pivot > kLost ? pivot : 0.0f);
        if (pivot > kLost) {
          sum[c] /= std::sqrt(pivot);
          for (int r = 0; r < c; ++r) sum[c][r] = 0.0f;
        } else {
          sum[c] = F8{};
        }
        target[c] = sum[c];
      }
      F8* inverse = inverse_.data() + 8 * i;
      for (int c = 0; c < 8; ++c) {
        if (target[c][c] == 0.0f) continue;
        for (int r = c; r < 8; ++r) {
          if (target[r][r] == 0.0f) continue;
          float value = r == c ? 1.0f : 0.0f;
          for (int k = c; k < r; ++k) value -= target[k][r] * inverse[c][k];
          inverse[c][r] = value / target[r][r];
        }
      }
      for (int c = 0; c < 8; ++c)
        for (int r = 0; r < 8; ++r) inverse_transposed_[8 * i + r][c] = inverse[c][r];
    }
  }
  ListColumns();
  return smallest;
}

void BandCholesky::ListColumns() {
  below_begin_.assign(Blocks() + 1, 0);
  for (Index i = 0; i < Blocks(); ++i)
    for (Index j = first_[i]; j < i; ++j) ++below_begin_[j + 1];
  std::partial_sum(below_begin_.begin(), below_begin_.end(), below_begin_.begin());
  below_.resize(below_begin_.back());
  std::vector<Index> next(below_begin_.begin(), below_begin_.end() - 1);
  for (Index i = 0; i < Blocks(); ++i)
    for (Index j = first_[i]; j < i; ++j) below_[next[j]++] = {i, offset_[i] + j - first_[i]};
}

void BandCholesky::Solve(float* x) const {
  const Index blocks = Blocks();
  auto load = [&](Index i) { return (F8)_mm256_loadu_ps(x + 8 * i); };
  auto store = [&](Index i, F8 value) { _mm256_storeu_ps(x + 8 * i, (__m256)value); };
  auto apply = [](const F8* columns, const float* values, F8 sum[4], int count) {
    for (int k = 0; k < count; k += 4)
      for (int u = 0; u < 4; ++u) sum[u] += columns[k + u] * values[k + u];
  };
  for (Index i = 0; i < 8 * blocks; ++i) x[i] *= scale_[i];
  alignas(32) float rest[8];
  for (Index i = 0; i < blocks; ++i) {
    F8 sum[4] = {};
    apply(factor_.data() + 8 * static_cast<std::size_t>(offset_[i]), x + 8 * first_[i], sum,
          8 * (i - first_[i]));
    _mm256_store_ps(rest, (__m256)(load(i) - ((sum[0] + sum[1]) + (sum[2] + sum[3]))));
    F8 result[4] = {};
    apply(inverse_.data() + 8 * i, rest, result, 8);
    store(i, (result[0] + result[1]) + (result[2] + result[3]));
  }
  for (Index i = blocks; i-- > 0;) {
    // By columns: the blocks that the way there has read are read again, none transposed.
    F8 sum[8] = {};
    for (Index b = below_begin_[i]; b < below_begin_[i + 1]; ++b) {
      const F8* columns = factor_.data() + 8 * static_cast<std::size_t>(below_[b].block);
      const F8 values = load(below_[b].row);
      for (int c = 0; c < 8; ++c) sum[c] += columns[c] * values;
    }
    _mm256_store_ps(rest, (__m256)(load(i) - simd::Sums(sum)));
    F8 result[4] = {};
    apply(inverse_transposed_.data() + 8 * i, rest, result, 8);
    store(i, (result[0] + result[1]) + (result[2] + result[3]));
  }
  for (Index i = 0; i < 8 * blocks; ++i) x[i] *= scale_[i];
}

}  // namespace kerf
