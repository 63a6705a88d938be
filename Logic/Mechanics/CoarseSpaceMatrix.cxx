#include <algorithm>
#include <cmath>
#include <numeric>

#include "Mechanics/CoarseSpace.h"

// PᵀKP: gathered by cells of the lattice, factored, solved with.
namespace kerf {
namespace {

constexpr std::uint16_t kNone = 0xFFFF;

}  // namespace

std::vector<Index> CoarseSpace::CellsAt(const ElementField& field,
                                        const std::vector<char>& vertices) const {
  std::vector<char> found(parts_.size(), 0), here;
  for (const ElementField::Chunk& chunk : field.Chunks()) {
    here.resize(chunk.vertices.size());
    char any = 0;
    for (std::size_t v = 0; v < here.size(); ++v) any |= here[v] = vertices[chunk.vertices[v]];
    if (!any) continue;
    for (std::size_t i = 0; i < chunk.tet.size(); ++i) {
      const auto& corner = chunk.blocks[i / 8].corner;
      const std::size_t lane = i % 8;
      if (here[corner[0][lane]] | here[corner[1][lane]] | here[corner[2][lane]] |
          here[corner[3][lane]])
        found[cell_[chunk.vertices[corner[0][lane]]]] = 1;
    }
  }
  std::vector<Index> cells;
  for (std::size_t c = 0; c < found.size(); ++c)
    if (found[c]) cells.push_back(static_cast<Index>(c));
  return cells;
}

void CoarseSpace::Assemble(const Workers& workers, const ElementField& field,
                           const std::vector<Index>& cells) {
  std::vector<Index> place(parts_.size(), -1);
  for (std::size_t i = 0; i < cells.size(); ++i) place[cells[i]] = static_cast<Index>(i);
  std::vector<std::vector<std::pair<Index, Index>>> lanes(cells.size());  // chunk, lane
  std::vector<Index> here;
  for (std::size_t c = 0; c < field.Chunks().size(); ++c) {
    const ElementField::Chunk& chunk = field.Chunks()[c];
    here.resize(chunk.vertices.size());
    bool any = false;
    for (std::size_t v = 0; v < here.size(); ++v)
      any |= (here[v] = place[cell_[chunk.vertices[v]]]) >= 0;
    for (std::size_t i = 0; any && i < chunk.tet.size(); ++i) {
      const Index at = here[chunk.blocks[i / 8].corner[0][i % 8]];
      if (at >= 0) lanes[at].emplace_back(static_cast<Index>(c), static_cast<Index>(i));
    }
  }
  workers.ForChunks(static_cast<Index>(cells.size()), 8, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) AssembleCell(field, lanes[i], &parts_[cells[i]]);
  });
}

void CoarseSpace::AssembleCell(const ElementField& field,
                               const std::vector<std::pair<Index, Index>>& lanes,
                               Part* part) const {
  part->functions.clear();
  part->pairs.clear();
  if (lanes.empty()) return;
  std::vector<std::uint16_t> local(FunctionCount(), kNone);
  for (const auto& [c, i] : lanes) {
    const ElementField::Chunk& chunk = field.Chunks()[c];
    for (const auto& corner : chunk.blocks[i / 8].corner) {
      const Row& row = rows_[chunk.vertices[corner[i % 8]]];
      for (int k = 0; k < 4; ++k) {
        std::uint16_t& number = local[row.function[k]];
        if (row.weight[k] == 0.0f || number != kNone) continue;
        number = static_cast<std::uint16_t>(part->functions.size());
        part->functions.push_back(row.function[k]);
      }
    }
  }
  // With h_f the gradient of a coarse function and G_fg = Σ μ h_f h_gᵀ, a block of PᵀKP is
  // λ/μ G + Gᵀ + tr(G) I: Poisson's ratio, so λ/μ, is the same everywhere. G is dense, by rows of
  // three components of each function.
  const std::size_t m = part->functions.size(), width = (3 * m + 7) / 8;
  std::vector<simd::F8> gram(3 * m * width, simd::F8{}), gradient(width);
  const auto component = [&](std::size_t i) -> float& {
    return reinterpret_cast<float*>(gradient.data())[i];
  };
  float ratio = 0.0f;
  for (const auto& [c, i] : lanes) {
    const ElementField::Chunk& chunk = field.Chunks()[c];
    const ElementBlock& block = chunk.blocks[i / 8];
    const int lane = static_cast<int>(i % 8);
    const Eigen::Matrix<float, 3, 4> g = LaneGradients(chunk.states[i / 8], lane);
    std::fill(gradient.begin(), gradient.end(), simd::F8{});
    std::uint16_t function[16];
    int count = 0;
    for (int a = 0; a < 4; ++a) {
      const Row& row = rows_[chunk.vertices[block.corner[a][lane]]];
      for (int k = 0; k < 4; ++k) {
        if (row.weight[k] == 0.0f) continue;
        const std::uint16_t number = local[row.function[k]];
        if (std::find(function, function + count, number) == function + count)
          function[count++] = number;
        for (int r = 0; r < 3; ++r) component(3 * number + r) += row.weight[k] * g(r, a);
      }
    }
    const float mu = 0.5f * block.two_mu[lane];
    ratio = block.lambda[lane] / mu;
    for (int s = 0; s < count; ++s)
      for (std::size_t row = 3 * function[s]; row < 3 * function[s] + 3u; ++row) {
        const float scaled = mu * component(row);
        // Pairs count once: from the diagonal on.
        for (std::size_t w = 3 * function[s] / 8u; w < width; ++w)
          gram[row * width + w] += scaled * gradient[w];
      }
  }
  for (std::size_t f = 0; f < m; ++f)
    for (std::size_t g = f; g < m; ++g) {
      const auto at = [&](std::size_t r, std::size_t c) {
        return gram[(3 * f + r) * width + (3 * g + c) / 8][(3 * g + c) % 8];
      };
      const float trace = at(0, 0) + at(1, 1) + at(2, 2);
      Pair pair{part->functions[f], part->functions[g], {}};
      float size = 0.0f;
      for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c) {
          pair.block[3 * r + c] = ratio * at(r, c) + at(c, r) + (r == c ? trace : 0.0f);
          size += std::abs(at(r, c));
        }
      if (size > 0.0f) part->pairs.push_back(pair);
    }
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
  // All functions of a part or a load are coupled with the first one of them.
  const auto reach = [&](const auto* functions, std::size_t count) {
    Index lowest = used_;
    for (std::size_t i = 0; i < count; ++i) lowest = std::min(lowest, position_[functions[i]]);
    for (std::size_t i = 0; i < count; ++i)
      for (Index r = 0; r < 3; ++r) {
        Index& block = first[(3 * position_[functions[i]] + r) / 8];
        block = std::min(block, 3 * lowest / 8);
      }
  };
  for (const Part& part : parts_) reach(part.functions.data(), part.functions.size());
  for (const LoadRow& row : load_rows) reach(row.function, static_cast<std::size_t>(row.count));
  factor_.SetProfile(unknowns, std::move(first));
  for (const Part& part : parts_)
    for (const Pair& pair : part.pairs)
      factor_.AddBlock(3 * position_[pair.row], 3 * position_[pair.column], pair.block);
  for (std::size_t l = 0; l < load_rows.size(); ++l) {
    const float* m = loads.Loads()[l].matrix;
    const LoadRow& row = load_rows[l];
    for (int s = 0; s < row.count; ++s)
      for (int t = 0; t <= s; ++t) {
        const float w = row.weight[s] * row.weight[t];
        const float block[9] = {w * m[0], w * m[5], w * m[4], w * m[5], w * m[1],
                                w * m[3], w * m[4], w * m[3], w * m[2]};
        factor_.AddBlock(3 * position_[row.function[s]], 3 * position_[row.function[t]], block);
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
