// How an ElementField follows a cut: at a cost that follows the cut, apart from passes over flat
// arrays.
#include <algorithm>
#include <numeric>

#include "Mechanics/ElementField.h"

namespace kerf {
namespace {
/// Tetrahedra that a thread looks at at a time.
constexpr Index kTetChunk = 8192;
}  // namespace

void ElementField::LayOutSlots() {
  // Chunks have room to grow by a few cuts; if one outgrew it, all move.
  const bool fits = std::all_of(chunks_.begin(), chunks_.end(), [](const Chunk& chunk) {
    return static_cast<Index>(chunk.vertices.size()) <= chunk.slot_room;
  });
  if (!fits) {
    Index slots = 0;
    std::vector<simd::F4> gradient;
    for (Chunk& chunk : chunks_) {
      const Index count = static_cast<Index>(chunk.vertices.size());
      const auto old = gradient_.begin() + chunk.slot_begin;
      gradient.resize(slots);
      gradient.insert(gradient.end(), old, old + std::min(count, chunk.slot_room));
      chunk.slot_begin = slots;
      chunk.slot_room = count + count / 8 + 16;
      slots += chunk.slot_room;
    }
    gradient.resize(slots);
    gradient_ = std::move(gradient);
    product_.assign(slots, {});
  }
  slot_begin_.assign(VertexCount() + 1, 0);
  for (const Chunk& chunk : chunks_)
    for (Index inner : chunk.vertices) ++slot_begin_[inner + 1];
  std::partial_sum(slot_begin_.begin(), slot_begin_.end(), slot_begin_.begin());
  slot_.resize(slot_begin_.back());
  std::vector<Index> next(slot_begin_.begin(), slot_begin_.end() - 1);
  for (const Chunk& chunk : chunks_) {
    Index slot = chunk.slot_begin;
    for (Index inner : chunk.vertices) slot_[next[inner]++] = slot++;
  }
}

void ElementField::RenumberVertices(const TopologyChange& change, Patch* patch) {
  const Index old_count = VertexCount(), count = change.mesh.VertexCount();
  // A vertex that is one old vertex keeps its inner number; of several copies the first one does.
  std::vector<Index> inner_of_outer(count, -1);
  std::vector<char> in_use(old_count, 0);
  for (Index v = 0; v < count; ++v)
    for (int k = 0; k < 4; ++k) {
      if (change.vertex_weights(v, k) != 1.0) continue;
      const Index inner = inner_of_outer_[change.vertex_parents[v][k]];
      if (in_use[inner]) break;
      in_use[inner] = 1;
      inner_of_outer[v] = inner;
      break;
    }
  Index next_hole = 0, used = old_count;
  for (Index v = 0; v < count; ++v) {
    if (inner_of_outer[v] >= 0) continue;
    while (next_hole < old_count && in_use[next_hole]) ++next_hole;
    inner_of_outer[v] = next_hole < old_count ? next_hole++ : used++;
    patch->new_vertices.push_back(inner_of_outer[v]);
    std::array<Index, 4> parents;
    for (int k = 0; k < 4; ++k) parents[k] = inner_of_outer_[change.vertex_parents[v][k]];
    patch->parents.push_back(parents);
    int heaviest = 0;
    patch->only_copies &= change.vertex_weights.row(v).maxCoeff(&heaviest) == 1.0;
    patch->origins.push_back(parents[heaviest]);
  }
  inner_of_outer_ = std::move(inner_of_outer);
  outer_of_inner_.assign(used, -1);
  for (Index v = 0; v < count; ++v) outer_of_inner_[inner_of_outer_[v]] = v;
}

ElementField::Patch ElementField::Apply(const Workers& workers, const TetMesh& mesh,
                                        const Material& material, const TopologyChange& change) {
  Patch patch;
  RenumberVertices(change, &patch);
  // Only tetrahedra at new vertices can have other corners than before.
  std::vector<char> is_new_vertex(mesh.VertexCount(), 0);
  for (Index inner : patch.new_vertices) is_new_vertex[outer_of_inner_[inner]] = 1;
  // What becomes of each tetrahedron of before: two bits beside its new number, so that a chunk has
  // one place to look at.
  enum : Index { kIsParent = 1, kIsChanged = 2, kNumber = 4 };
  std::vector<Index> fate(change.kept_tet.size());
  workers.ForChunks(static_cast<Index>(fate.size()), kTetChunk, [&](Index begin, Index end) {
    for (Index t = begin; t < end; ++t) {
      const Index kept = change.kept_tet[t];
      if (kept < 0) {
        fate[t] = kIsChanged;
        continue;
      }
      const Index* corner = mesh.tets.data() + 4 * kept;
      const bool other_corners = is_new_vertex[corner[0]] | is_new_vertex[corner[1]] |
                                 is_new_vertex[corner[2]] | is_new_vertex[corner[3]];
      fate[t] = kNumber * kept + (other_corners ? kIsChanged : 0);
    }
  });
  for (Index t : change.new_tets) fate[change.parent_tet[t]] |= kIsParent;
  // New tetrahedra join the chunk of their parent.
  std::vector<char> rebuilt(chunks_.size(), 0);
  std::vector<std::vector<std::pair<Index, Index>>> parents(chunks_.size());  // parent, its lane
  std::vector<std::vector<Index>> left(chunks_.size());
  workers.ForChunks(static_cast<Index>(chunks_.size()), 1, [&](Index c, Index) {
    for (std::size_t i = 0; i < chunks_[c].tet.size(); ++i) {
      Index& t = chunks_[c].tet[i];
      const Index now = fate[t];
      if (now & (kIsParent | kIsChanged)) {
        rebuilt[c] = 1;
        if (now & kIsParent) parents[c].emplace_back(t, static_cast<Index>(i));
        if (now & kIsChanged)
          left[c].push_back(chunks_[c].vertices[chunks_[c].blocks[i / 8].corner[0][i % 8]]);
        t = change.kept_tet[t];
      } else {
        t = now / kNumber;
      }
    }
    std::sort(parents[c].begin(), parents[c].end());
  });
  std::vector<std::pair<Index, Index>> children;  // parent, child
  for (Index t : change.new_tets) children.emplace_back(change.parent_tet[t], t);
  std::sort(children.begin(), children.end());
  for (std::size_t c = 0; c < chunks_.size(); ++c)
    if (rebuilt[c]) {
      patch.chunks.push_back(static_cast<Index>(c));
      patch.left.insert(patch.left.end(), left[c].begin(), left[c].end());
    }
  workers.ForChunks(static_cast<Index>(patch.chunks.size()), 1, [&](Index which, Index) {
    const Index c = patch.chunks[which];
    std::vector<std::pair<Index, Index>> added;  // tetrahedron, lane of its parent
    for (const auto& [parent, lane] : parents[c])
      for (auto child = std::lower_bound(children.begin(), children.end(),
                                         std::make_pair(parent, Index{-1}));
           child != children.end() && child->first == parent; ++child)
        added.emplace_back(child->second, lane);
    std::sort(added.begin(), added.end());
    RebuildChunk(mesh, material, added, &chunks_[c]);
  });
  LayOutSlots();
  return patch;
}

void ElementField::RebuildChunk(const TetMesh& mesh, const Material& material,
                                const std::vector<std::pair<Index, Index>>& added,
                                Chunk* chunk) const {
  // New tetrahedra take the places of those gone, which may be their parents; the others stay.
  std::vector<Mat3> rotations;
  for (const auto& [t, lane] : added)
    rotations.push_back(LaneRotation(chunk->states[lane / 8], static_cast<int>(lane % 8)));
  std::vector<Index>& tets = chunk->tet;
  const auto resize = [&](std::size_t size) {
    tets.resize(size, -1);
    chunk->blocks.resize((size + 7) / 8);
    chunk->states.resize(chunk->blocks.size());
  };
  std::size_t place = 0;
  for (std::size_t n = 0; n < added.size(); ++n) {
    while (place < tets.size() && tets[place] >= 0) ++place;
    if (place == tets.size()) resize(place + added.size() - n);
    const int lane = static_cast<int>(place % 8);
    tets[place] = added[n].first;
    SetLane(MakeElement(mesh, material, tets[place]), lane, &chunk->blocks[place / 8]);
    SetLaneRotation(rotations[n], chunk->blocks[place / 8], lane, &chunk->states[place / 8]);
  }
  std::size_t size = tets.size();
  for (; place < size; ++place) {
    if (tets[place] >= 0) continue;
    while (size > place && tets[size - 1] < 0) --size;
    if (size == place) break;
    --size;
    tets[place] = tets[size];
    CopyLane(chunk->blocks[size / 8], chunk->states[size / 8], static_cast<int>(size % 8),
             static_cast<int>(place % 8), &chunk->blocks[place / 8], &chunk->states[place / 8]);
  }
  resize(size);
  chunk->stale = true;
  if (size > 0) {
    std::vector<Index> scratch(VertexCount(), -1);
    NumberChunk(mesh, &scratch, chunk);
  } else {
    chunk->vertices.clear();
  }
  MeasureChunk(chunk);
}

}  // namespace kerf
