#include <algorithm>
#include <cmath>
#include <numeric>

#include "Mechanics/CoarseSpace.h"

// PᵀKP: gathered by cells of the lattice, factored, solved with.
namespace kerf {
namespace {

constexpr std::uint16_t kNone = 0xFFFF;
/// Functions at the end of the factor: they make it dense there. While no cut grows, fewer.
constexpr std::size_t kMostGrown = 64, kMostGrownAtRest = 16;
/// A smaller pivot of theirs says that loads have changed since the factor was made: what is left
/// of a function beside its parent's would be mere difference of the two.
constexpr float kLeastPivot = 0.02f;

}  // namespace

std::vector<CoarseSpace::CellLanes> CoarseSpace::LanesAt(const ElementField& field,
                                                         const std::vector<char>& vertices,
                                                         int corners) const {
  std::vector<CellLanes> cells;
  std::vector<Index> place(parts_.size(), -1);
  std::vector<char> here;
  for (std::size_t c = 0; c < field.Chunks().size(); ++c) {
    const ElementField::Chunk& chunk = field.Chunks()[c];
    here.resize(chunk.vertices.size());
    char any = 0;
    for (std::size_t v = 0; v < here.size(); ++v) any |= here[v] = vertices[chunk.vertices[v]];
    for (std::size_t i = 0; any && i < chunk.tet.size(); ++i) {
      const auto& corner = chunk.blocks[i / 8].corner;
      bool at = false;
      for (int a = 0; a < corners; ++a) at |= here[corner[a][i % 8]] != 0;
      if (!at) continue;
      Index& where = place[cell_[chunk.vertices[corner[0][i % 8]]]];
      if (where < 0) {
        where = static_cast<Index>(cells.size());
        cells.push_back({cell_[chunk.vertices[corner[0][i % 8]]], {}});
      }
      cells[where].lanes.emplace_back(static_cast<Index>(c), static_cast<Index>(i));
    }
  }
  return cells;
}

void CoarseSpace::AssembleStale(const Workers& workers, const ElementField& field) {
  std::vector<char> vertices(cell_.size());
  for (std::size_t v = 0; v < vertices.size(); ++v) vertices[v] = stale_[cell_[v]];
  const std::vector<CellLanes> cells = LanesAt(field, vertices, 1);
  for (std::size_t c = 0; c < parts_.size(); ++c)
    if (stale_[c]) parts_[c] = {};
  std::fill(stale_.begin(), stale_.end(), 0);
  const std::vector<char> all(FunctionCount(), 1);
  workers.ForChunks(static_cast<Index>(cells.size()), 8, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i)
      parts_[cells[i].cell] = AssembleCell(field, cells[i].lanes, all);
  });
}

void CoarseSpace::AssembleGrown(const Workers& workers, const ElementField& field) {
  if (grown_cells_.empty()) return;
  std::vector<char> is_new(FunctionCount(), 0);
  for (std::size_t f = extended_; f < grown_.size(); ++f) is_new[grown_[f]] = 1;
  grown_parts_.resize(grown_cells_.size());
  workers.ForChunks(static_cast<Index>(grown_cells_.size()), 2, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i)
      grown_parts_[i] = AssembleCell(field, grown_cells_[i].lanes, is_new);
  });
  grown_cells_.clear();
}

CoarseSpace::Part CoarseSpace::AssembleCell(const ElementField& field, const Lanes& lanes,
                                            const std::vector<char>& wanted) const {
  Part part;
  std::vector<std::uint16_t> local(FunctionCount(), kNone);
  for (const auto& [c, i] : lanes) {
    const ElementField::Chunk& chunk = field.Chunks()[c];
    for (const auto& corner : chunk.blocks[i / 8].corner) {
      const Row& row = rows_[chunk.vertices[corner[i % 8]]];
      for (int k = 0; k < 4; ++k) {
        if (row.weight[k] == 0.0f || local[row.function[k]] != kNone) continue;
        local[row.function[k]] = 0;
        part.functions.push_back(row.function[k]);
      }
    }
  }
  // Those wanted come first.
  const std::size_t wanted_count = static_cast<std::size_t>(
      std::stable_partition(part.functions.begin(), part.functions.end(),
                            [&](std::uint16_t f) { return wanted[f] != 0; }) -
      part.functions.begin());
  for (std::size_t f = 0; f < part.functions.size(); ++f)
    local[part.functions[f]] = static_cast<std::uint16_t>(f);
  // With h_f the gradient of a coarse function and G_fg = Σ μ h_f h_gᵀ, a block of PᵀKP is
  // λ/μ G + Gᵀ + tr(G) I: Poisson's ratio, so λ/μ, is the same everywhere. G = HᵀH, where a row of
  // H has a tetrahedron's √μ h of all functions.
  const std::size_t m = part.functions.size(), width = (3 * m + 7) / 8,
                    height = (3 * wanted_count + 7) / 8;
  std::vector<simd::F8> rows(lanes.size() * width, simd::F8{}), gram(8 * height * width);
  float ratio = 0.0f;
  for (std::size_t t = 0; t < lanes.size(); ++t) {
    const ElementField::Chunk& chunk = field.Chunks()[lanes[t].first];
    const ElementBlock& block = chunk.blocks[lanes[t].second / 8];
    const int lane = static_cast<int>(lanes[t].second % 8);
    float* const h = reinterpret_cast<float*>(rows.data() + t * width);
    const float mu = 0.5f * block.two_mu[lane], root = std::sqrt(mu);
    ratio = block.lambda[lane] / mu;
    float first[3] = {};
    for (int a = 3; a >= 0; --a) {
      float g[3];
      for (int r = 0; r < 3; ++r) {
        g[r] = a > 0 ? root * block.B[3 * a - 3 + r][lane] : first[r];
        first[r] -= g[r];
      }
      const Row& row = rows_[chunk.vertices[block.corner[a][lane]]];
      for (int k = 0; k < 4; ++k) {
        if (row.weight[k] == 0.0f) continue;
        for (int r = 0; r < 3; ++r) h[3 * local[row.function[k]] + r] += row.weight[k] * g[r];
      }
    }
  }
  for (std::size_t i = 0; i < height; ++i)
    for (std::size_t j = i; j < width; ++j) {
      simd::F8 sum[8] = {};
      for (std::size_t t = 0; t < lanes.size(); ++t) {
        const simd::F8 left = rows[t * width + i], right = rows[t * width + j];
        for (int r = 0; r < 8; ++r) sum[r] += left[r] * right;
      }
      for (std::size_t r = 0; r < 8; ++r) gram[(8 * i + r) * width + j] = sum[r];
    }
  const float* const entries = reinterpret_cast<const float*>(gram.data());
  for (std::size_t f = 0; f < wanted_count; ++f)
    for (std::size_t g = f; g < m; ++g) {
      // Below the diagonal of G it is its transpose that is known.
      const auto at = [&](std::size_t r, std::size_t c) {
        const std::size_t i = 3 * f + r, j = 3 * g + c;
        return i <= j ? entries[8 * width * i + j] : entries[8 * width * j + i];
      };
      const float trace = at(0, 0) + at(1, 1) + at(2, 2);
      Pair pair{part.functions[f], part.functions[g], {}};
      float size = 0.0f;
      for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c) {
          pair.block[3 * r + c] = ratio * at(r, c) + at(c, r) + (r == c ? trace : 0.0f);
          size += std::abs(at(r, c));
        }
      if (size > 0.0f) part.pairs.push_back(pair);
    }
  return part;
}

std::vector<CoarseSpace::LoadRow> CoarseSpace::LoadRows(const FeatureLoads& loads) const {
  std::vector<LoadRow> rows(loads.Loads().size());
  for (std::size_t l = 0; l < rows.size(); ++l) {
    LoadRow& out = rows[l];
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
  return rows;
}

void CoarseSpace::LoadRow::Block(const FeatureLoads::Load& load, int s, int t,
                                 float block[9]) const {
  const float w = weight[s] * weight[t];
  const float* m = load.matrix;
  const int entry[9] = {0, 5, 4, 5, 1, 3, 4, 3, 2};
  for (int i = 0; i < 9; ++i) block[i] = w * m[entry[i]];
}

std::vector<float> CoarseSpace::LumpedAnchors(const std::vector<float>& anchor) const {
  std::vector<float> lumped(FunctionCount(), 0.0f);
  for (std::size_t v = 0; v < rows_.size(); ++v)
    for (int k = 0; k < 4; ++k) lumped[rows_[v].function[k]] += rows_[v].weight[k] * anchor[v];
  return lumped;
}

void CoarseSpace::Factor(const Workers& workers, const ElementField& field,
                         const FeatureLoads& loads, const std::vector<float>& anchor) {
  AssembleStale(workers, field);
  OrderFunctions();
  const std::vector<LoadRow> load_rows = LoadRows(loads);
  std::vector<Index> first(
      (3 * static_cast<std::size_t>(
               std::count_if(position_.begin(), position_.end(), [](Index p) { return p >= 0; })) +
       7) /
      8);
  std::iota(first.begin(), first.end(), 0);
  // All functions of a part or a load are coupled with the first one of them.
  const auto reach = [&](const auto* functions, std::size_t count) {
    Index lowest = 8 * static_cast<Index>(first.size());
    for (std::size_t i = 0; i < count; ++i) lowest = std::min(lowest, position_[functions[i]]);
    for (std::size_t i = 0; i < count; ++i)
      for (Index r = 0; r < 3; ++r) {
        Index& block = first[(position_[functions[i]] + r) / 8];
        block = std::min(block, lowest / 8);
      }
  };
  for (const Part& part : parts_) reach(part.functions.data(), part.functions.size());
  for (const LoadRow& row : load_rows) reach(row.function, static_cast<std::size_t>(row.count));
  factor_.SetProfile(std::move(first), 3 * kMostGrown / 8);
  for (const Part& part : parts_)
    for (const Pair& pair : part.pairs)
      factor_.AddBlock(position_[pair.row], position_[pair.column], pair.block);
  float block[9];
  for (std::size_t l = 0; l < load_rows.size(); ++l)
    for (int s = 0; s < load_rows[l].count; ++s)
      for (int t = 0; t <= s; ++t) {
        load_rows[l].Block(loads.Loads()[l], s, t, block);
        factor_.AddBlock(position_[load_rows[l].function[s]], position_[load_rows[l].function[t]],
                         block);
      }
  const std::vector<float> lumped = LumpedAnchors(anchor);
  for (Index f = 0; f < FunctionCount(); ++f)
    if (position_[f] >= 0)
      for (int r = 0; r < 3; ++r) factor_.Add(position_[f] + r, position_[f] + r, lumped[f]);
  factor_.Factor();
}

bool CoarseSpace::IsLong() const { return grown_.size() > kMostGrownAtRest; }

bool CoarseSpace::Extend(const FeatureLoads& loads, const std::vector<float>& anchor) {
  if (grown_.size() > kMostGrown) return false;
  const Index from = factor_.Blocks();
  std::vector<char> is_new(FunctionCount(), 0);
  position_.resize(FunctionCount(), -1);
  for (Index next = 8 * from; extended_ < grown_.size(); ++extended_, next += 3) {
    position_[grown_[extended_]] = next;
    is_new[grown_[extended_]] = 1;
  }
  const auto has_new = [&](const auto* functions, std::size_t count) {
    return std::any_of(functions, functions + count, [&](auto f) { return is_new[f] != 0; });
  };
  std::vector<std::pair<const LoadRow*, const FeatureLoads::Load*>> pulls;
  const std::vector<LoadRow> load_rows = LoadRows(loads);
  Index lowest = 8 * from;
  const auto reach = [&](const auto* functions, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) {
      Index f = functions[i];
      while (parent_[f] >= 0) f = parent_[f];
      lowest = std::min(lowest, position_[f]);
    }
  };
  for (const Part& part : grown_parts_) reach(part.functions.data(), part.functions.size());
  for (std::size_t l = 0; l < load_rows.size(); ++l)
    if (has_new(load_rows[l].function, static_cast<std::size_t>(load_rows[l].count))) {
      pulls.emplace_back(&load_rows[l], &loads.Loads()[l]);
      reach(load_rows[l].function, static_cast<std::size_t>(load_rows[l].count));
    }
  factor_.Append((position_[grown_.back()] + 3 + 7) / 8 - from, lowest / 8);
  // A function in the factor is the sum of those split off from it and of what is left of it.
  const auto add = [&](Index row, Index column, const float block[9]) {
    if (!is_new[row]) return;
    for (Index f = column; f >= 0; f = parent_[f])
      if (position_[f] <= position_[row]) factor_.AddBlock(position_[row], position_[f], block);
  };
  for (const Part& part : grown_parts_)
    for (const Pair& pair : part.pairs) {
      add(pair.row, pair.column, pair.block);
      if (pair.row == pair.column) continue;
      const float* b = pair.block;
      const float transposed[9] = {b[0], b[3], b[6], b[1], b[4], b[7], b[2], b[5], b[8]};
      add(pair.column, pair.row, transposed);
    }
  float block[9];
  for (const auto& [row, load] : pulls)
    for (int s = 0; s < row->count; ++s)
      for (int t = 0; t < row->count; ++t) {
        row->Block(*load, s, t, block);
        add(row->function[s], row->function[t], block);
      }
  const std::vector<float> lumped = LumpedAnchors(anchor);
  for (Index f = 0; f < FunctionCount(); ++f) {
    const float held[9] = {lumped[f], 0, 0, 0, lumped[f], 0, 0, 0, lumped[f]};
    if (is_new[f]) add(f, f, held);
  }
  grown_parts_.clear();
  return factor_.Factor(from) >= kLeastPivot;
}

void CoarseSpace::Solve(simd::F4* c) const {
  work_.assign(8 * static_cast<std::size_t>(factor_.Blocks()), 0.0f);
  const auto at = [&](Index f) { return work_.data() + position_[f]; };
  for (Index f = 0; f < FunctionCount(); ++f)
    if (position_[f] >= 0) {
      at(f)[0] = c[f].x;
      at(f)[1] = c[f].y;
      at(f)[2] = c[f].z;
    }
  const auto add = [&](Index from, Index to) {
    for (int r = 0; r < 3; ++r) at(to)[r] += at(from)[r];
  };
  for (auto f = grown_.rbegin(); f != grown_.rend(); ++f) add(*f, parent_[*f]);
  factor_.Solve(work_.data());
  for (Index f : grown_) add(parent_[f], f);
  for (Index f = 0; f < FunctionCount(); ++f)
    c[f] = position_[f] >= 0 ? simd::F4{at(f)[0], at(f)[1], at(f)[2], 0.0f} : simd::F4{};
}

}  // namespace kerf
