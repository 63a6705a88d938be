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

void CoarseSpace::Reset(const Workers& workers, const std::vector<Vec3>& rest,
                        const ElementField& field) {
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
    cell_.assign(rest.size(), 0);
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
  parts_.assign(size_.prod(), {});
  stale_.assign(size_.prod(), 1);
  links_.clear();
  for (const ElementField::Chunk& chunk : field.Chunks()) links_.push_back(LinkChunk(chunk));
  parent_.clear();
  std::vector<Index> changed;
  Split(field, std::vector<char>(size_.prod(), 1), std::vector<char>(rest.size(), 0), &changed);
  AssembleStale(workers, field);  // now: what is reset beside the frames is not to cost one of them
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
  const auto number = [&] {
    return (corner.x() * size_.y() + corner.y()) * size_.z() + corner.z();
  };
  cell_[inner] = number();
  int axis[3] = {0, 1, 2};
  std::stable_sort(axis, axis + 3, [&](int a, int b) { return fraction[a] > fraction[b]; });
  double upper = 1.0;
  for (int k = 0; k < 4; ++k) {
    const double lower = k < 3 ? fraction[axis[k]] : 0.0;
    row.weight[k] = static_cast<float>(upper - lower);
    // Tiny weights would tie functions to vertices that hardly feel them.
    if (row.weight[k] < 1e-4f) row.weight[k] = 0.0f;
    node_[4 * inner + k] = row.weight[k] > 0.0f ? number() : -1;
    upper = lower;
    if (k < 3) ++corner[axis[k]];
  }
}

std::vector<std::uint16_t> CoarseSpace::LinkChunk(const ElementField::Chunk& chunk) const {
  // Vertices that share a tetrahedron and a node are connected at that node: a chain through the
  // entries of a node connects them all.
  std::vector<std::uint16_t> parent(4 * chunk.vertices.size());
  std::iota(parent.begin(), parent.end(), std::uint16_t{0});
  const auto root = [&](std::uint16_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  std::vector<std::array<Index, 4>> nodes(chunk.vertices.size());
  for (std::size_t v = 0; v < nodes.size(); ++v)
    std::copy_n(node_.begin() + 4 * chunk.vertices[v], 4, nodes[v].begin());
  std::vector<std::pair<Index, std::uint16_t>> last_at_node(functions_of_node_.size(), {-1, 0});
  for (Index i = 0; i < static_cast<Index>(chunk.tet.size()); ++i)
    for (const auto& corner : chunk.blocks[i / 8].corner) {
      const std::uint16_t vertex = corner[i % 8];
      for (int k = 0; k < 4; ++k) {
        if (nodes[vertex][k] < 0) continue;
        const std::uint16_t entry = static_cast<std::uint16_t>(4 * vertex + k);
        auto& [visited, last] = last_at_node[nodes[vertex][k]];
        if (visited == i && parent[entry] != parent[last]) {
          const std::uint16_t p = root(entry), q = root(last);
          parent[std::max(p, q)] = std::min(p, q);
        }
        visited = i;
        last = entry;
      }
    }
  for (std::size_t e = 0; e < parent.size(); ++e) parent[e] = root(static_cast<std::uint16_t>(e));
  return parent;
}

Index CoarseSpace::NewFunction(Index node, Index parent) {
  Index function = 0;
  while (function < FunctionCount() && node_of_function_[function] >= 0) ++function;
  if (function == FunctionCount()) {
    node_of_function_.push_back(-1);
    parent_.push_back(-1);
  }
  node_of_function_[function] = node;
  functions_of_node_[node].push_back(function);
  parent_[function] = parent;
  grown_.push_back(function);
  return function;
}

CoarseSpace::Change CoarseSpace::Split(const ElementField& field,
                                       const std::vector<char>& flagged_nodes,
                                       const std::vector<char>& is_old,
                                       std::vector<Index>* changed) {
  // Row entries at flagged nodes, by the vertices that have some.
  struct Entry {
    Index node;
    int k;  ///< in the row
  };
  std::vector<Entry> entries;
  std::vector<Index> near, entries_begin;
  std::vector<char> is_near(rows_.size(), 0);
  std::vector<std::array<Index, 4>> entry_of(rows_.size(), {-1, -1, -1, -1});
  for (Index v = 0; v < static_cast<Index>(rows_.size()); ++v) {
    const std::size_t before = entries.size();
    for (int k = 0; k < 4; ++k) {
      const Index node = node_[4 * v + k];
      if (node < 0 || !flagged_nodes[node]) continue;
      entry_of[v][k] = static_cast<Index>(entries.size());
      entries.push_back({node, k});
    }
    if (entries.size() == before) continue;
    near.push_back(v);
    is_near[v] = 1;
    entries_begin.push_back(static_cast<Index>(before));
  }
  entries_begin.push_back(static_cast<Index>(entries.size()));
  // What is connected at a node within a chunk is known; the vertices that chunks share do the
  // rest.
  std::vector<Index> parent(entries.size());
  std::iota(parent.begin(), parent.end(), 0);
  for (std::size_t c = 0; c < links_.size(); ++c) {
    const std::vector<Index>& vertices = field.Chunks()[c].vertices;
    for (std::size_t v = 0; v < vertices.size(); ++v) {
      if (!is_near[vertices[v]]) continue;
      for (int k = 0; k < 4; ++k) {
        const Index e = entry_of[vertices[v]][k];
        const Index linked = links_[c][4 * v + k];
        if (e < 0 || linked == static_cast<Index>(4 * v) + k) continue;
        const Index p = FindRoot(&parent, e),
                    q = FindRoot(&parent, entry_of[vertices[linked / 4]][linked % 4]);
        parent[std::max(p, q)] = std::min(p, q);
      }
    }
  }
  std::vector<float> weight(entries.size(), 0.0f), total(flagged_nodes.size(), 0.0f);
  std::vector<Index> origin(entries.size(), -1);  // what its old vertices had
  bool nested = true;
  for (std::size_t n = 0; n < near.size(); ++n)
    for (Index e = entries_begin[n]; e < entries_begin[n + 1]; ++e) {
      const Index root = FindRoot(&parent, e), v = near[n];
      weight[root] += rows_[v].weight[entries[e].k];
      total[entries[e].node] += rows_[v].weight[entries[e].k];
      if (!is_old[v]) continue;
      if (origin[root] < 0) origin[root] = rows_[v].function[entries[e].k];
      nested &= origin[root] == rows_[v].function[entries[e].k];
    }
  // The heaviest part keeps the function that parts have in common, and so do crumbs (copies at the
  // rim of a support): only a real split is worth a function.
  std::vector<Index> heaviest(flagged_nodes.size(), -1), keeper(FunctionCount(), -1);
  const auto take_heavier = [&](Index part, Index* most) {
    if (*most < 0 || weight[part] > weight[*most]) *most = part;
  };
  for (Index e = 0; e < static_cast<Index>(entries.size()); ++e) {
    if (!(weight[e] > 0.0f)) continue;
    take_heavier(e, &heaviest[entries[e].node]);
    if (origin[e] >= 0) take_heavier(e, &keeper[origin[e]]);
  }
  std::vector<Index> vanished;
  for (std::size_t node = 0; node < flagged_nodes.size(); ++node) {
    if (!flagged_nodes[node]) continue;
    std::vector<Index>& functions = functions_of_node_[node];
    for (Index function : functions)
      if (keeper[function] < 0) vanished.push_back(function);
    functions.erase(std::remove_if(functions.begin(), functions.end(),
                                   [&](Index function) { return keeper[function] < 0; }),
                    functions.end());
  }
  const std::size_t before = grown_.size();
  std::vector<Index> function_of_root(entries.size(), -1);
  for (Index e = 0; e < static_cast<Index>(entries.size()); ++e) {
    if (!(weight[e] > 0.0f)) continue;
    const bool is_crumb = weight[e] < kCrumb * total[entries[e].node];
    if (origin[e] >= 0 && (is_crumb || keeper[origin[e]] == e)) {
      function_of_root[e] = origin[e];
    } else if (!is_crumb || heaviest[entries[e].node] == e) {
      nested &= origin[e] >= 0;
      function_of_root[e] = NewFunction(entries[e].node, origin[e]);
    }
  }
  for (Index function : vanished) node_of_function_[function] = -1;
  for (std::size_t n = 0; n < near.size(); ++n) {
    const Index v = near[n];
    bool differs = false;
    for (Index e = entries_begin[n]; e < entries_begin[n + 1]; ++e) {
      const auto [node, k] = entries[e];
      Index function = function_of_root[FindRoot(&parent, e)];
      if (function < 0) function = function_of_root[heaviest[node]];
      differs |= is_old[v] && rows_[v].function[k] != function;
      rows_[v].function[k] = static_cast<std::uint16_t>(function);
    }
    if (differs) changed->push_back(v);
  }
  if (grown_.size() == before && vanished.empty() && changed->empty()) return Change::kNone;
  return nested && vanished.empty() ? Change::kGrown : Change::kOther;
}

void CoarseSpace::FollowVertices(const std::vector<Vec3>& rest, const ElementField& field,
                                 const ElementField::Patch& patch) {
  // Tetrahedra of other shapes belong to no cell any more, or to another one.
  if (!patch.only_copies)
    for (Index v : patch.left) stale_[cell_[v]] = 1;
  rows_.resize(rest.size());
  node_.resize(4 * rest.size(), -1);
  cell_.resize(rest.size(), 0);
  for (Index v = 0; v < static_cast<Index>(rest.size()); ++v)
    if (field.Outer(v) < 0) {
      rows_[v] = {};
      std::fill_n(node_.begin() + 4 * v, 4, -1);
    }
  for (Index v : patch.new_vertices) SetRow(rest[v], v);
}

void CoarseSpace::FollowChunk(const ElementField& field, Index chunk) {
  links_[chunk] = LinkChunk(field.Chunks()[chunk]);
}

CoarseSpace::Change CoarseSpace::FollowNodes(const ElementField& field,
                                             const ElementField::Patch& patch) {
  // Only a vertex that came as a copy can have cut the support of a node in two.
  std::vector<char> flagged(functions_of_node_.size(), 0), is_old(rows_.size(), 1);
  for (Index v : patch.new_vertices) {
    is_old[v] = 0;
    for (int k = 0; k < 4; ++k)
      if (node_[4 * v + k] >= 0) flagged[node_[4 * v + k]] = 1;
  }
  const bool is_extended = extended_ == grown_.size();
  std::vector<Index> changed;
  const Change change = Split(field, flagged, is_old, &changed);
  // With the same functions, a copy moves as its original does: the Galerkin matrix is what it was.
  if (change == Change::kNone && patch.only_copies) return change;
  std::vector<char> is_changed(rows_.size(), 0);
  for (Index v : changed) is_changed[v] = 1;
  for (Index v : patch.new_vertices) is_changed[v] = 1;
  std::vector<CellLanes> cells = LanesAt(field, is_changed, 4);
  for (const CellLanes& cell : cells) stale_[cell.cell] = 1;
  // Tetrahedra of other shapes at the same functions are little of their matrix: it waits for them.
  if (change == Change::kNone) return change;
  if (change == Change::kOther || !is_extended) return Change::kOther;
  grown_cells_ = std::move(cells);
  return change;
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
  for (std::size_t i = 0; i < order.size(); ++i)
    position_[order[i].second] = 3 * static_cast<Index>(i);
  parent_.assign(FunctionCount(), -1);
  grown_.clear();
  extended_ = 0;
}

}  // namespace kerf
