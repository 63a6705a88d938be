#include "Mechanics/CoarseSpace.h"

#include <cmath>
#include <numeric>

namespace kerf {
namespace {

/// Lattice nodes for a mesh: a few hundred are cheap to solve for and keep the iteration count
/// independent of the mesh; small meshes get fewer, or the coarse level would cost more than it
/// saves.
Index NodeTarget(Index vertices) { return std::clamp<Index>(vertices / 6, 12, 250); }

/// Parts of a node's support with less than this fraction of its weight get no function of their
/// own.
constexpr float kCrumb = 0.15f;

Index FindRoot(std::vector<Index>* parent, Index i) {
  while ((*parent)[i] != i) i = (*parent)[i] = (*parent)[(*parent)[i]];
  return i;
}

}  // namespace

void CoarseSpace::Reset(const std::vector<Vec3>& rest, const ElementField& field) {
  Vec3 low = Vec3::Zero(), high = Vec3::Zero();
  if (!rest.empty()) low = high = rest[0];
  for (const Vec3& p : rest) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const Index target = NodeTarget(static_cast<Index>(rest.size()));
  // The number of nodes that are reached grows as the cells shrink; a few corrections find the cell
  // size.
  cell_mm_ = std::max(1e-3, std::cbrt((high - low).prod() / target));
  for (int attempt = 0;; ++attempt) {
    size_ = ((high - low) / cell_mm_).array().ceil().cast<int>() + 1;
    origin_ = 0.5 * (low + high) - 0.5 * cell_mm_ * (size_.cast<double>() - Vec3::Ones());
    rows_.assign(rest.size(), {});
    node_.assign(4 * rest.size(), -1);
    for (Index v = 0; v < static_cast<Index>(rest.size()); ++v) SetRow(rest[v], v);
    std::vector<char> reached(size_.prod(), 0);
    for (Index node : node_)
      if (node >= 0) reached[node] = 1;
    const double count = static_cast<double>(std::accumulate(reached.begin(), reached.end(), 0));
    if (attempt == 6 || std::abs(count - target) < 0.1 * target) break;
    cell_mm_ *= std::cbrt(count / target);
  }
  node_of_function_.clear();
  functions_of_node_.assign(size_.prod(), {});
  parts_.assign(field.Chunks().size(), {});
  bool altered = false;
  Split(field, std::vector<char>(size_.prod(), 1), std::vector<char>(rest.size(), 0), &altered);
  OrderFunctions();
}

void CoarseSpace::SetRow(const Vec3& rest, Index inner) {
  // The simplex of the cell is found by sorting the fractions; its corners are reached one axis
  // after the other.
  Row& row = rows_[inner];
  row = {};
  Vec3 fraction = (rest - origin_) / cell_mm_;
  Eigen::Vector3i corner;
  for (int i = 0; i < 3; ++i) {
    corner[i] = std::clamp(static_cast<int>(std::floor(fraction[i])), 0, std::max(0, size_[i] - 2));
    fraction[i] = std::clamp(fraction[i] - corner[i], 0.0, 1.0);
  }
  int axis[3] = {0, 1, 2};
  std::stable_sort(axis, axis + 3, [&](int a, int b) { return fraction[a] > fraction[b]; });
  double upper = 1.0;
  for (int k = 0; k < 4; ++k) {
    const double lower = k < 3 ? fraction[axis[k]] : 0.0;
    row.weight[k] = static_cast<float>(upper - lower);
    // Tiny weights would tie functions to vertices that hardly feel them.
    if (row.weight[k] < 1e-4f) row.weight[k] = 0.0f;
    node_[4 * inner + k] =
        row.weight[k] > 0.0f ? (corner.x() * size_.y() + corner.y()) * size_.z() + corner.z() : -1;
    upper = lower;
    if (k < 3) ++corner[axis[k]];
  }
}

std::vector<Index> CoarseSpace::Split(const ElementField& field,
                                      const std::vector<char>& flagged_nodes,
                                      const std::vector<char>& is_old, bool* altered) {
  const Index vertices = static_cast<Index>(rows_.size());
  std::vector<char> near(vertices, 0);
  std::vector<Index> parent(node_.size());
  for (Index e = 0; e < static_cast<Index>(node_.size()); ++e) {
    parent[e] = e;
    if (node_[e] >= 0 && flagged_nodes[node_[e]]) near[e / 4] = 1;
  }
  // Vertices that share a tetrahedron and a node are connected at that node.
  for (const ElementField::Chunk& chunk : field.Chunks()) {
    if (std::none_of(chunk.vertices.begin(), chunk.vertices.end(),
                     [&](Index v) { return near[v]; }))
      continue;
    for (std::size_t i = 0; i < chunk.tet.size(); ++i) {
      Index entry[16];
      int count = 0;
      for (int a = 0; a < 4; ++a) {
        const Index v = chunk.vertices[chunk.blocks[i / 8].corner[a][i % 8]];
        if (!near[v]) continue;
        for (Index e = 4 * v; e < 4 * v + 4; ++e)
          if (node_[e] >= 0 && flagged_nodes[node_[e]]) entry[count++] = e;
      }
      // A chain through the entries of a node connects them all.
      for (int s = 0; s < count; ++s)
        for (int t = s + 1; t < count; ++t)
          if (node_[entry[s]] == node_[entry[t]]) {
            const Index p = FindRoot(&parent, entry[s]), q = FindRoot(&parent, entry[t]);
            parent[std::max(p, q)] = std::min(p, q);
            break;
          }
    }
  }
  // Crumbs (copies at the rim of a support) stay with the heaviest part: only a real split is worth
  // a function.
  std::vector<float> weight(node_.size(), 0.0f), total(flagged_nodes.size(), 0.0f);
  std::vector<Index> heaviest(flagged_nodes.size(), -1);
  for (Index e = 0; e < static_cast<Index>(node_.size()); ++e)
    if (node_[e] >= 0 && flagged_nodes[node_[e]]) {
      const float w = rows_[e / 4].weight[e % 4];
      weight[FindRoot(&parent, e)] += w;
      total[node_[e]] += w;
    }
  for (Index e = 0; e < static_cast<Index>(node_.size()); ++e)
    if (weight[e] > 0.0f && (heaviest[node_[e]] < 0 || weight[e] > weight[heaviest[node_[e]]]))
      heaviest[node_[e]] = e;
  // Each part keeps the function of its first vertex where no other part has it.
  std::vector<std::pair<Index, std::vector<Index>>> before;
  for (std::size_t node = 0; node < flagged_nodes.size(); ++node)
    if (flagged_nodes[node]) {
      for (Index function : functions_of_node_[node]) node_of_function_[function] = -1;
      before.emplace_back(static_cast<Index>(node), std::move(functions_of_node_[node]));
      functions_of_node_[node].clear();
    }
  std::vector<Index> function_of_root(node_.size(), -1), changed;
  Index next_free = 0;
  for (Index v = 0; v < vertices; ++v) {
    if (!near[v] || field.Outer(v) < 0) continue;
    bool differs = false;
    for (int k = 0; k < 4; ++k) {
      const Index node = node_[4 * v + k];
      if (node < 0 || !flagged_nodes[node]) continue;
      Index root = FindRoot(&parent, 4 * v + k);
      if (weight[root] < kCrumb * total[node]) root = heaviest[node];
      Index& function = function_of_root[root];
      if (function < 0) {
        const Index old = rows_[v].function[k];
        if (is_old[v] && old < FunctionCount() && node_of_function_[old] < 0) {
          function = old;
        } else {
          while (next_free < FunctionCount() && node_of_function_[next_free] >= 0) ++next_free;
          if (next_free == FunctionCount()) node_of_function_.push_back(-1);
          function = next_free;
        }
        node_of_function_[function] = static_cast<Index>(node);
        functions_of_node_[node].push_back(function);
      }
      differs |= is_old[v] && rows_[v].function[k] != function;
      rows_[v].function[k] = static_cast<std::uint16_t>(function);
    }
    if (differs) changed.push_back(v);
  }
  *altered = false;
  for (const auto& [node, functions] : before) *altered |= functions_of_node_[node] != functions;
  return changed;
}

bool CoarseSpace::Apply(const std::vector<Vec3>& rest, const ElementField& field,
                        const ElementField::Patch& patch, std::vector<Index>* stale) {
  rows_.resize(rest.size());
  node_.resize(4 * rest.size(), -1);
  for (Index v = 0; v < static_cast<Index>(rest.size()); ++v)
    if (field.Outer(v) < 0) {
      rows_[v] = {};
      std::fill_n(node_.begin() + 4 * v, 4, -1);
    }
  // Only a vertex that came as a copy can have cut the support of a node in two.
  std::vector<char> flagged(functions_of_node_.size(), 0), is_old(rest.size(), 1);
  for (Index v : patch.new_vertices) {
    SetRow(rest[v], v);
    is_old[v] = 0;
    for (int k = 0; k < 4; ++k)
      if (node_[4 * v + k] >= 0) flagged[node_[4 * v + k]] = 1;
  }
  bool altered = false;
  const std::vector<Index> changed = Split(field, flagged, is_old, &altered);
  stale->clear();
  // With the same functions, a copy moves as its original does: the Galerkin matrix is what it was.
  if (!altered && changed.empty()) return false;
  OrderFunctions();
  std::vector<char> is_changed(rest.size(), 0), is_stale(field.Chunks().size(), 0);
  for (Index v : changed) is_changed[v] = 1;
  for (Index v : patch.new_vertices) is_changed[v] = 1;
  for (Index c = 0; c < static_cast<Index>(is_stale.size()); ++c) {
    for (Index v : field.Chunks()[c].vertices) is_stale[c] |= is_changed[v];
    if (is_stale[c]) stale->push_back(c);
  }
  return true;
}

void CoarseSpace::OrderFunctions() {
  // Slabs across the longest axis give the narrowest band.
  int axis[3] = {0, 1, 2};
  std::stable_sort(axis, axis + 3, [&](int a, int b) { return size_[a] > size_[b]; });
  std::vector<std::pair<Index, Index>> order;
  for (Index f = 0; f < FunctionCount(); ++f) {
    const Index node = node_of_function_[f];
    if (node < 0) continue;
    const int at[3] = {node / (size_.y() * size_.z()), node / size_.z() % size_.y(),
                       node % size_.z()};
    order.emplace_back((at[axis[0]] * size_[axis[1]] + at[axis[1]]) * size_[axis[2]] + at[axis[2]],
                       f);
  }
  std::sort(order.begin(), order.end());
  position_.assign(FunctionCount(), -1);
  used_ = static_cast<Index>(order.size());
  for (Index i = 0; i < used_; ++i) position_[order[i].second] = i;
}

void CoarseSpace::Assemble(const Workers& workers, const ElementField& field,
                           const std::vector<Index>& chunks) {
  workers.ForChunks(static_cast<Index>(chunks.size()), 1, [&](Index which, Index) {
    const ElementField::Chunk& chunk = field.Chunks()[chunks[which]];
    std::vector<Pair>& part = parts_[chunks[which]];
    part.clear();
    std::vector<Index> local(FunctionCount(), -1), functions;
    for (Index v : chunk.vertices)
      for (int k = 0; k < 4; ++k)
        if (rows_[v].weight[k] > 0.0f && local[rows_[v].function[k]] < 0) {
          local[rows_[v].function[k]] = static_cast<Index>(functions.size());
          functions.push_back(rows_[v].function[k]);
        }
    const std::size_t m = functions.size();
    std::vector<Index> pair_at(m * m, -1);
    for (std::size_t i = 0; i < chunk.tet.size(); ++i) {
      const ElementBlock& block = chunk.blocks[i / 8];
      const int lane = static_cast<int>(i % 8);
      const Mat3 R = LaneRotation(chunk.states[i / 8], lane);
      Corners g;
      for (int a = 0; a < 3; ++a)
        g.col(a + 1) =
            R * Vec3(block.B[3 * a][lane], block.B[3 * a + 1][lane], block.B[3 * a + 2][lane]);
      g.col(0) = -(g.col(1) + g.col(2) + g.col(3));
      // Gradients of the coarse functions on this tetrahedron.
      Index function[16];
      Vec3 h[16];
      int count = 0;
      for (int a = 0; a < 4; ++a) {
        const Row& row = rows_[chunk.vertices[block.corner[a][lane]]];
        for (int k = 0; k < 4; ++k) {
          if (row.weight[k] == 0.0f) continue;
          int j = 0;
          while (j < count && function[j] != row.function[k]) ++j;
          if (j == count) {
            function[count] = row.function[k];
            h[count++] = Vec3::Zero();
          }
          h[j] += static_cast<double>(row.weight[k]) * g.col(a);
        }
      }
      const double mu = 0.5 * static_cast<double>(block.two_mu[lane]);
      const double lambda = static_cast<double>(block.lambda[lane]);
      for (int s = 0; s < count; ++s)
        for (int t = 0; t < count; ++t) {
          if (function[s] > function[t]) continue;
          Index& slot =
              pair_at[static_cast<std::size_t>(local[function[s]]) * m + local[function[t]]];
          if (slot < 0) {
            slot = static_cast<Index>(part.size());
            part.push_back({static_cast<std::uint16_t>(function[s]),
                            static_cast<std::uint16_t>(function[t]),
                            {}});
          }
          float* b = part[slot].block;
          const double dot = mu * h[s].dot(h[t]);
          for (int r = 0; r < 3; ++r)
            for (int c = 0; c < 3; ++c)
              b[3 * r + c] += static_cast<float>(lambda * h[s][r] * h[t][c] +
                                                 mu * h[t][r] * h[s][c] + (r == c ? dot : 0.0));
        }
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
