// Parts of an ElementField: what is around a few vertices.
#include <algorithm>

#include "Mechanics/ElementField.h"

namespace kerf {
namespace {

/// Lanes of a chunk with a corner where `inside` (by inner vertex) is set.
template <class Visit>
void ForLanesAt(const ElementField::Chunk& chunk, const std::vector<char>& inside,
                const Visit& visit) {
  std::vector<char> here(chunk.vertices.size());
  for (std::size_t v = 0; v < here.size(); ++v) here[v] = inside[chunk.vertices[v]];
  for (std::size_t i = 0; i < chunk.tet.size(); ++i) {
    const auto& corner = chunk.blocks[i / 8].corner;
    const std::size_t lane = i % 8;
    if (here[corner[0][lane]] | here[corner[1][lane]] | here[corner[2][lane]] |
        here[corner[3][lane]])
      visit(chunk.blocks[i / 8], static_cast<int>(lane), chunk.states[i / 8]);
  }
}

}  // namespace

std::vector<Index> ElementField::ChunksOf(const std::vector<Index>& vertices) const {
  std::vector<char> touched(chunks_.size(), 0);
  for (Index v : vertices)
    for (Index s = slot_begin_[v]; s < slot_begin_[v + 1]; ++s) {
      const auto after =
          std::upper_bound(chunks_.begin(), chunks_.end(), slot_[s],
                           [](Index slot, const Chunk& chunk) { return slot < chunk.slot_begin; });
      touched[after - chunks_.begin() - 1] = 1;
    }
  std::vector<Index> chunks;
  for (std::size_t c = 0; c < touched.size(); ++c)
    if (touched[c]) chunks.push_back(static_cast<Index>(c));
  return chunks;
}

std::vector<Index> ElementField::Surroundings(std::vector<Index> vertices, int rings) const {
  std::vector<char> inside(VertexCount(), 0), grown;
  for (Index v : vertices) inside[v] = 1;
  for (int ring = 0; ring < rings; ++ring) {
    grown = inside;
    for (Index c : ChunksOf(vertices))
      ForLanesAt(chunks_[c], inside, [&](const ElementBlock& block, int lane, const auto&) {
        for (const auto& corner : block.corner) {
          const Index v = chunks_[c].vertices[corner[lane]];
          if (!grown[v]) vertices.push_back(v);
          grown[v] = 1;
        }
      });
    inside.swap(grown);
  }
  std::sort(vertices.begin(), vertices.end());
  return vertices;
}

void ElementField::Extract(const std::vector<Index>& vertices, Excerpt* excerpt) const {
  std::vector<char> inside(VertexCount(), 0);
  std::vector<Index> number(VertexCount(), -1);
  excerpt->vertices = vertices;
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    inside[vertices[i]] = 1;
    number[vertices[i]] = static_cast<Index>(i);
  }
  excerpt->chunks = ChunksOf(vertices);
  excerpt->blocks.clear();
  excerpt->states.clear();
  int lanes = 0;
  for (Index c : excerpt->chunks)
    ForLanesAt(chunks_[c], inside,
               [&](const ElementBlock& block, int lane, const ElementState& state) {
                 if (lanes % 8 == 0) {
                   excerpt->blocks.emplace_back();
                   excerpt->states.emplace_back();
                 }
                 ElementBlock& to = excerpt->blocks.back();
                 CopyLane(block, state, lane, lanes % 8, &to, &excerpt->states.back());
                 for (int a = 0; a < 4; ++a) {
                   const Index v = chunks_[c].vertices[block.corner[a][lane]];
                   if (number[v] < 0) {
                     number[v] = static_cast<Index>(excerpt->vertices.size());
                     excerpt->vertices.push_back(v);
                   }
                   to.corner[a][lanes % 8] = static_cast<std::uint16_t>(number[v]);
                 }
                 ++lanes;
               });
  if (lanes > 0) PadLanes((lanes - 1) % 8, &excerpt->blocks.back(), &excerpt->states.back());
}

void ElementField::MarkStale(const std::vector<Index>& chunks) {
  for (Index c : chunks) chunks_[c].stale = true;
}

}  // namespace kerf
