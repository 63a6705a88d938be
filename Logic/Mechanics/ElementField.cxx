#include "Mechanics/ElementField.h"

#include <numeric>

namespace kerf {
namespace {

/// Tetrahedra per chunk: small enough for the first-level cache and for two threads to share the
/// work of a small mesh, large enough that few vertices belong to several chunks.
Index ChunkSize(Index tets) { return std::clamp<Index>(tets / 16 / 8 * 8, 128, 1024); }

/// Halves the range along its longest side until it fits a chunk.
void Bisect(const Points& centroids, Index* begin, Index* end, Index size,
            std::vector<std::vector<Index>>* parts) {
  const Index count = static_cast<Index>(end - begin);
  if (count <= size) {
    parts->emplace_back(begin, end);
    return;
  }
  Vec3 low = centroids.row(*begin).transpose(), high = low;
  for (const Index* t = begin; t < end; ++t) {
    low = low.cwiseMin(centroids.row(*t).transpose());
    high = high.cwiseMax(centroids.row(*t).transpose());
  }
  int axis = 0;
  (high - low).maxCoeff(&axis);
  // Whole chunks on the left, so that only the last chunk has a remainder.
  const Index chunks = (count + size - 1) / size;
  Index* middle = begin + (chunks / 2) * size;
  std::nth_element(begin, middle, end, [&](Index a, Index b) {
    return centroids(a, axis) != centroids(b, axis) ? centroids(a, axis) < centroids(b, axis)
                                                    : a < b;
  });
  Bisect(centroids, begin, middle, size, parts);
  Bisect(centroids, middle, end, size, parts);
}

/// Orders a chunk so that the tetrahedra of a block share no vertex where possible: the kernels add
/// to one vertex after the other, and adding to the same one twice in a row has to wait.
void SpreadVertices(const TetMesh& mesh, std::vector<Index>* tets, std::vector<Index>* last_block) {
  std::vector<Index> left = std::move(*tets), rest;
  std::sort(left.begin(), left.end());
  tets->clear();
  for (Index block = 1; !left.empty(); ++block) {
    rest.clear();
    int lanes = 0;
    for (Index t : left) {
      const auto is_free = [&](Index v) { return (*last_block)[v] != block; };
      const auto corner = mesh.tets.row(t);
      if (lanes == 8 || !std::all_of(corner.begin(), corner.end(), is_free)) {
        rest.push_back(t);
        continue;
      }
      for (Index v : corner) (*last_block)[v] = block;
      tets->push_back(t);
      ++lanes;
    }
    const int missing = std::min<int>(8 - lanes, static_cast<int>(rest.size()));
    tets->insert(tets->end(), rest.begin(), rest.begin() + missing);
    left.assign(rest.begin() + missing, rest.end());
  }
  for (Index t : *tets)
    for (Index v : mesh.tets.row(t)) (*last_block)[v] = 0;
}

}  // namespace

void ElementField::Reset(const TetMesh& mesh, const Material& material) {
  Points centroids(mesh.TetCount(), 3);
  for (Index t = 0; t < mesh.TetCount(); ++t) {
    centroids.row(t).setZero();
    for (int a = 0; a < 4; ++a) centroids.row(t) += 0.25 * mesh.rest.row(mesh.tets(t, a));
  }
  std::vector<Index> order(mesh.TetCount());
  std::iota(order.begin(), order.end(), 0);
  std::vector<std::vector<Index>> parts;
  if (!order.empty())
    Bisect(centroids, order.data(), order.data() + order.size(), ChunkSize(mesh.TetCount()),
           &parts);

  inner_of_outer_.assign(mesh.VertexCount(), -1);
  outer_of_inner_.clear();
  auto number = [&](Index outer) {
    if (inner_of_outer_[outer] >= 0) return;
    inner_of_outer_[outer] = static_cast<Index>(outer_of_inner_.size());
    outer_of_inner_.push_back(outer);
  };
  std::vector<Index> last_block(mesh.VertexCount(), 0);
  for (auto& part : parts) {
    SpreadVertices(mesh, &part, &last_block);
    for (Index t : part)
      for (int a = 0; a < 4; ++a) number(mesh.tets(t, a));
  }
  for (Index v = 0; v < mesh.VertexCount(); ++v) number(v);

  chunks_.assign(parts.size(), {});
  std::vector<Index> scratch(VertexCount(), -1);
  for (std::size_t c = 0; c < parts.size(); ++c) {
    Chunk& chunk = chunks_[c];
    chunk.tet = parts[c];
    chunk.blocks.resize((chunk.tet.size() + 7) / 8);
    chunk.states.resize(chunk.blocks.size());
    for (std::size_t i = 0; i < chunk.tet.size(); ++i) {
      SetLane(MakeElement(mesh, material, chunk.tet[i]), static_cast<int>(i % 8),
              &chunk.blocks[i / 8]);
      SetLaneRotation(Mat3::Identity(), chunk.blocks[i / 8], static_cast<int>(i % 8),
                      &chunk.states[i / 8]);
    }
    NumberChunk(mesh, &scratch, &chunk);
    MeasureChunk(&chunk);
  }
  LayOutSlots();
}

void ElementField::NumberChunk(const TetMesh& mesh, std::vector<Index>* number_of_inner,
                               Chunk* chunk) const {
  chunk->vertices.clear();
  for (std::size_t i = 0; i < chunk->tet.size(); ++i)
    for (int a = 0; a < 4; ++a) {
      const Index inner = inner_of_outer_[mesh.tets(chunk->tet[i], a)];
      Index& number = (*number_of_inner)[inner];
      if (number < 0) {
        number = static_cast<Index>(chunk->vertices.size());
        chunk->vertices.push_back(inner);
      }
      chunk->blocks[i / 8].corner[a][i % 8] = static_cast<std::uint16_t>(number);
    }
  for (Index inner : chunk->vertices) (*number_of_inner)[inner] = -1;
  PadLanes(static_cast<int>((chunk->tet.size() - 1) % 8), &chunk->blocks.back(),
           &chunk->states.back());
}

void ElementField::MeasureChunk(Chunk* chunk) {
  std::vector<std::uint16_t>& part = chunk->part;
  part.resize(chunk->vertices.size());
  std::iota(part.begin(), part.end(), std::uint16_t{0});
  chunk->volume_mm3.assign(chunk->vertices.size(), 0.0f);
  auto root = [&](std::uint16_t v) {
    while (part[v] != v) v = part[v] = part[part[v]];
    return v;
  };
  for (std::size_t i = 0; i < chunk->tet.size(); i += 8) {
    const ElementBlock& block = chunk->blocks[i / 8];
    const simd::F8 quarter = QuarterVolumes(block);
    const int lanes = static_cast<int>(std::min<std::size_t>(8, chunk->tet.size() - i));
    for (int lane = 0; lane < lanes; ++lane)
      for (int a = 0; a < 4; ++a) {
        chunk->volume_mm3[block.corner[a][lane]] += quarter[lane];
        const std::uint16_t p = root(block.corner[0][lane]), q = root(block.corner[a][lane]);
        part[std::max(p, q)] = std::min(p, q);
      }
  }
  for (std::size_t v = 0; v < part.size(); ++v) part[v] = root(static_cast<std::uint16_t>(v));
}

std::vector<double> ElementField::LumpedVolumes() const {
  std::vector<double> volume(VertexCount(), 0.0);
  for (const Chunk& chunk : chunks_)
    for (std::size_t i = 0; i < chunk.vertices.size(); ++i)
      volume[chunk.vertices[i]] += static_cast<double>(chunk.volume_mm3[i]);
  return volume;
}

Index ElementField::Components(std::vector<Index>* component) const {
  std::vector<Index> parent(VertexCount());
  std::iota(parent.begin(), parent.end(), 0);
  auto root = [&](Index v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  for (const Chunk& chunk : chunks_)
    for (std::size_t i = 0; i < chunk.vertices.size(); ++i) {
      const Index p = root(chunk.vertices[i]), q = root(chunk.vertices[chunk.part[i]]);
      parent[std::max(p, q)] = std::min(p, q);
    }
  // Roots are the smallest of their component, so they come first.
  Index count = 0;
  component->resize(VertexCount());
  for (Index v = 0; v < VertexCount(); ++v)
    (*component)[v] = parent[v] == v ? count++ : (*component)[root(v)];
  return count;
}

double ElementField::Linearize(const Workers& workers, const simd::F4* x, bool only_stale) {
  workers.ForChunks(static_cast<Index>(chunks_.size()), 1, [&](Index c, Index) {
    Chunk& chunk = chunks_[c];
    if (only_stale && !chunk.stale) return;
    thread_local std::vector<simd::F4> local;
    local.resize(chunk.vertices.size());
    for (std::size_t i = 0; i < local.size(); ++i) local[i] = x[chunk.vertices[i]];
    simd::F4* gradient = gradient_.data() + chunk.slot_begin;
    std::fill(gradient, gradient + chunk.vertices.size(), simd::F4{});
    chunk.energy_nJ =
        kerf::Linearize(chunk.blocks.data(), chunk.states.data(),
                        static_cast<int>(chunk.blocks.size()), local.data(), gradient);
    chunk.stale = false;
  });
  double energy = 0.0;
  for (const Chunk& chunk : chunks_) energy += chunk.energy_nJ;
  return energy;
}

double ElementField::MultiplyChunk(Index c, const simd::F4* p) {
  const Chunk& chunk = chunks_[c];
  thread_local std::vector<simd::F4> local;
  local.resize(chunk.vertices.size());
  for (std::size_t i = 0; i < local.size(); ++i) local[i] = p[chunk.vertices[i]];
  simd::F4* product = product_.data() + chunk.slot_begin;
  std::fill(product, product + chunk.vertices.size(), simd::F4{});
  return AddProduct(chunk.blocks.data(), chunk.states.data(), static_cast<int>(chunk.blocks.size()),
                    local.data(), product);
}

void ElementField::ResetRotations() {
  for (Chunk& chunk : chunks_)
    for (std::size_t b = 0; b < chunk.states.size(); ++b) {
      ElementState& state = chunk.states[b];
      state.q[0] = simd::Splat(1.0f);
      state.q[1] = state.q[2] = state.q[3] = simd::F8{};
      std::copy_n(chunk.blocks[b].B, 9, state.RB);
    }
}

}  // namespace kerf
