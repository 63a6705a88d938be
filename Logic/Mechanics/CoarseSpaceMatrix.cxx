#include <numeric>

#include "Mechanics/CoarseSpace.h"

// PᵀKP: gathered by chunks, factored, solved with.
namespace kerf {
namespace {

constexpr std::uint16_t kNone = 0xFFFF;

}  // namespace

void CoarseSpace::Assemble(const Workers& workers, const ElementField& field,
                           const std::vector<Index>& chunks) {
  workers.ForChunks(static_cast<Index>(chunks.size()), 1, [&](Index which, Index) {
    const ElementField::Chunk& chunk = field.Chunks()[chunks[which]];
    std::vector<Pair>& part = parts_[chunks[which]];
    part.clear();
    // Functions by their number in this chunk, so that a pair is found without a search.
    std::vector<std::uint16_t> local(FunctionCount(), kNone), functions;
    std::vector<std::array<std::uint16_t, 4>> of_vertex(chunk.vertices.size());
    for (std::size_t v = 0; v < of_vertex.size(); ++v)
      for (int k = 0; k < 4; ++k) {
        const Row& row = rows_[chunk.vertices[v]];
        std::uint16_t& number = local[row.function[k]];
        if (row.weight[k] > 0.0f && number == kNone) {
          number = static_cast<std::uint16_t>(functions.size());
          functions.push_back(row.function[k]);
        }
        of_vertex[v][k] = row.weight[k] > 0.0f ? number : kNone;
      }
    const std::size_t m = functions.size();
    std::vector<Index> pair_at(m * m, -1);
    std::vector<std::array<simd::F4, 3>> sums;  // rows of each block
    for (std::size_t i = 0; i < chunk.tet.size(); ++i) {
      const ElementBlock& block = chunk.blocks[i / 8];
      const int lane = static_cast<int>(i % 8);
      const Eigen::Matrix<float, 3, 4> g = LaneGradients(chunk.states[i / 8], lane);
      // Gradients of the coarse functions on this tetrahedron.
      std::uint16_t function[16];
      simd::F4 h[16];
      int count = 0;
      for (int a = 0; a < 4; ++a) {
        const std::uint16_t v = block.corner[a][lane];
        const Row& row = rows_[chunk.vertices[v]];
        for (int k = 0; k < 4; ++k) {
          if (of_vertex[v][k] == kNone) continue;
          int j = 0;
          while (j < count && function[j] != of_vertex[v][k]) ++j;
          if (j == count) {
            function[count] = of_vertex[v][k];
            h[count++] = {};
          }
          h[j].x += row.weight[k] * g(0, a);
          h[j].y += row.weight[k] * g(1, a);
          h[j].z += row.weight[k] * g(2, a);
        }
      }
      const __m128 mu = _mm_set1_ps(0.5f * block.two_mu[lane]);
      const __m128 lambda = _mm_set1_ps(block.lambda[lane]);
      for (int s = 0; s < count; ++s)
        for (int t = s; t < count; ++t) {
          const bool ordered = functions[function[s]] <= functions[function[t]];
          const int row = ordered ? s : t, column = ordered ? t : s;
          Index& slot = pair_at[function[row] * m + function[column]];
          if (slot < 0) {
            slot = static_cast<Index>(part.size());
            part.push_back({functions[function[row]], functions[function[column]], {}});
            sums.emplace_back();
          }
          // λ h_r h_cᵀ + μ (h_c h_rᵀ + h_r·h_c I), row by row.
          const __m128 hr = simd::Load(h[row]), hc = simd::Load(h[column]);
          const __m128 lc = _mm_mul_ps(lambda, hc), mr = _mm_mul_ps(mu, hr);
          const float dot = simd::Dot3(mr, hc);
          const float r[3] = {h[row].x, h[row].y, h[row].z};
          const float c[3] = {h[column].x, h[column].y, h[column].z};
          for (int k = 0; k < 3; ++k) {
            simd::F4* sum = &sums[slot][k];
            const __m128 products =
                _mm_add_ps(_mm_mul_ps(_mm_set1_ps(r[k]), lc), _mm_mul_ps(_mm_set1_ps(c[k]), mr));
            simd::Store(sum, _mm_add_ps(simd::Load(*sum), products));
          }
          sums[slot][0].x += dot;
          sums[slot][1].y += dot;
          sums[slot][2].z += dot;
        }
    }
    for (std::size_t p = 0; p < part.size(); ++p)
      for (int k = 0; k < 3; ++k) {
        part[p].block[3 * k] = sums[p][k].x;
        part[p].block[3 * k + 1] = sums[p][k].y;
        part[p].block[3 * k + 2] = sums[p][k].z;
      }
  });
}

void CoarseSpace::Factor(const FeatureLoads& loads, const std::vector<float>& anchor) {
  struct LoadRow {
    int count = 0;
    Index function[16];
    float weight[16];
  };
  std::vector<LoadRow> load_rows(loads.Loads().size());
  for (std::size_t l = 0; l < load_rows.size(); ++l) {
    LoadRow& out = load_rows[l];
    for (int a = 0; a < 4; ++a) {
      const float w = loads.Loads()[l].weight[a];
      const Row& row = rows_[loads.Loads()[l].vertex[a]];
      if (w == 0.0f) continue;
      for (int k = 0; k < 4; ++k) {
        if (row.weight[k] == 0.0f) continue;
        int j = 0;
        while (j < out.count && out.function[j] != row.function[k]) ++j;
        if (j == out.count) {
          out.function[out.count] = row.function[k];
          out.weight[out.count++] = 0.0f;
        }
        out.weight[j] += w * row.weight[k];
      }
    }
  }
  const Index unknowns = 3 * used_;
  std::vector<Index> first((unknowns + 7) / 8);
  std::iota(first.begin(), first.end(), 0);
  auto reach = [&](Index f, Index g) {
    const Index low = std::min(position_[f], position_[g]),
                high = std::max(position_[f], position_[g]);
    for (Index block = 3 * high / 8; block <= (3 * high + 2) / 8; ++block)
      first[block] = std::min(first[block], 3 * low / 8);
  };
  for (const auto& part : parts_)
    for (const Pair& pair : part) reach(pair.row, pair.column);
  for (const LoadRow& row : load_rows)
    for (int s = 0; s < row.count; ++s) reach(row.function[0], row.function[s]);
  for (const LoadRow& row : load_rows)
    for (int s = 0; s < row.count; ++s)
      for (int t = 0; t < s; ++t) reach(row.function[s], row.function[t]);
  factor_.SetProfile(unknowns, std::move(first));
  auto add = [&](Index f, Index g, const float* block) {
    const Index row = 3 * position_[f], column = 3 * position_[g];
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) {
        if (row > column || (row == column && r >= c))
          factor_.Add(row + r, column + c, block[3 * r + c]);
        if (row < column) factor_.Add(column + c, row + r, block[3 * r + c]);
      }
  };
  for (const auto& part : parts_)
    for (const Pair& pair : part) add(pair.row, pair.column, pair.block);
  for (std::size_t l = 0; l < load_rows.size(); ++l) {
    const float* m = loads.Loads()[l].matrix;
    const LoadRow& row = load_rows[l];
    for (int s = 0; s < row.count; ++s)
      for (int t = 0; t <= s; ++t) {
        const float w = row.weight[s] * row.weight[t];
        const float block[9] = {w * m[0], w * m[5], w * m[4], w * m[5], w * m[1],
                                w * m[3], w * m[4], w * m[3], w * m[2]};
        add(row.function[s], row.function[t], block);
      }
  }
  std::vector<float> lumped(FunctionCount(), 0.0f);
  for (std::size_t v = 0; v < rows_.size(); ++v)
    for (int k = 0; k < 4; ++k) lumped[rows_[v].function[k]] += rows_[v].weight[k] * anchor[v];
  for (Index f = 0; f < FunctionCount(); ++f)
    if (position_[f] >= 0)
      for (int r = 0; r < 3; ++r)
        factor_.Add(3 * position_[f] + r, 3 * position_[f] + r, lumped[f]);
  factor_.Factor();
}

void CoarseSpace::Solve(simd::F4* c) const {
  work_.assign(8 * static_cast<std::size_t>((3 * used_ + 7) / 8), 0.0f);
  for (Index f = 0; f < FunctionCount(); ++f)
    if (position_[f] >= 0) {
      float* at = work_.data() + 3 * position_[f];
      at[0] = c[f].x;
      at[1] = c[f].y;
      at[2] = c[f].z;
    }
  factor_.Solve(work_.data());
  for (Index f = 0; f < FunctionCount(); ++f) {
    const float* at = work_.data() + 3 * std::max<Index>(position_[f], 0);
    c[f] = position_[f] >= 0 ? simd::F4{at[0], at[1], at[2], 0.0f} : simd::F4{};
  }
}

}  // namespace kerf
