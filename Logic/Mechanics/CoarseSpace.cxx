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
  // Row entries at flagged nodes, and where each vertex has its own.
  const Index vertices = static_cast<Index>(rows_.size());
  std::vector<Index> entries, parent(node_.size(), -1);
  std::vector<char> near(vertices, 0);
  for (Index e = 0; e < static_cast<Index>(node_.size()); ++e)
    if (node_[e] >= 0 && flagged_nodes[node_[e]]) {
      entries.push_back(e);
      parent[e] = e;
      near[e / 4] = 1;
    }
  // Vertices that share a tetrahedron and a node are connected at that node: a chain through the
  // entries of a node connects them all.
  std::vector<std::pair<Index, Index>> last_at_node(flagged_nodes.size(), {-1, -1});
  Index visit = 0;
  for (const ElementField::Chunk& chunk : field.Chunks()) {
    std::vector<char> near_here(chunk.vertices.size());
    bool any = false;
    for (std::size_t v = 0; v < near_here.size(); ++v)
      any |= near_here[v] = near[chunk.vertices[v]];
    if (!any) continue;
    for (std::size_t i = 0; i < chunk.tet.size(); ++i, ++visit)
      for (int a = 0; a < 4; ++a) {
        const std::uint16_t corner = chunk.blocks[i / 8].corner[a][i % 8];
        if (!near_here[corner]) continue;
        for (Index e = 4 * chunk.vertices[corner]; e < 4 * chunk.vertices[corner] + 4; ++e) {
          if (parent[e] < 0) continue;
          auto& [visited, last] = last_at_node[node_[e]];
          if (visited == visit && parent[e] != parent[last]) {
            const Index p = FindRoot(&parent, e), q = FindRoot(&parent, last);
            parent[std::max(p, q)] = std::min(p, q);
          }
          visited = visit;
          last = e;
        }
      }
  }
  // Crumbs (copies at the rim of a support) stay with the heaviest part: only a real split is worth
  // a function.
  std::vector<float> weight(node_.size(), 0.0f), total(flagged_nodes.size(), 0.0f);
  std::vector<Index> heaviest(flagged_nodes.size(), -1);
  for (Index e : entries) {
    const float w = rows_[e / 4].weight[e % 4];
    weight[FindRoot(&parent, e)] += w;
    total[node_[e]] += w;
  }
  for (Index e : entries)
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

}  // namespace kerf
