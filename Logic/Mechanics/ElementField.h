#pragma once

#include <array>
#include <utility>
#include <vector>

#include "Core/TopologyChange.h"
#include "Mechanics/ElementKernels.h"
#include "Mechanics/Parallel.h"

namespace kerf {

/// The tetrahedra of a mesh for the fast solver: chunks of neighboring tetrahedra in blocks of
/// eight, each chunk with a numbering of its own vertices. A chunk writes its results to slots of
/// its own; a vertex sums its slots in a fixed order. So threads never write to the same place and
/// the sums don't depend on their number.
///
/// Vertices have an inner number (neighbors near in memory) beside that of the mesh. A cut keeps
/// inner numbers, chunks and linearizations of what it doesn't touch.
class ElementField {
 public:
  struct Chunk {
    std::vector<ElementBlock> blocks;
    std::vector<ElementState> states;
    std::vector<Index> tet;         ///< of each lane that is in use, in mesh numbering
    std::vector<Index> vertices;    ///< inner number of each chunk vertex
    std::vector<float> volume_mm3;  ///< of each chunk vertex: a quarter of its tetrahedra
    std::vector<std::uint16_t>
        part;  ///< of each chunk vertex: a chunk vertex that it is connected with, one per part
    Index slot_begin = 0, slot_room = 0;  ///< its slots; more of them than vertices
    double energy_nJ = 0.0;               ///< at the last linearization
    bool stale = true;                    ///< not linearized since it was built
  };

  /// What Apply changed, in inner numbers.
  struct Patch {
    std::vector<Index> new_vertices;  ///< inner vertices that are new (or elsewhere at rest)
    std::vector<std::array<Index, 4>> parents;  ///< theirs, in the inner numbers before
    std::vector<Index> origins;                 ///< the parent of most weight: of a copy, its only
    std::vector<Index> chunks;                  ///< rebuilt chunks
    bool only_copies = true;  ///< new vertices are copies of others, where those were
    std::vector<Index> left;  ///< first corners, in the inner numbers before, of tetrahedra that
                              ///< are gone or have other corners
  };

  /// A few tetrahedra apart from their chunks, with a numbering of their own.
  struct Excerpt {
    std::vector<Index> vertices;  ///< inner numbers; those asked for come first
    std::vector<Index> chunks;    ///< where the tetrahedra are from
    std::vector<ElementBlock> blocks;
    std::vector<ElementState> states;  ///< as last linearized
  };

  void Reset(const TetMesh& mesh, const Material& material);
  Patch Apply(const Workers& workers, const TetMesh& mesh, const Material& material,
              const TopologyChange& change);

  /// Inner vertices, holes left by cuts included.
  Index VertexCount() const { return static_cast<Index>(outer_of_inner_.size()); }
  Index Inner(Index mesh_vertex) const { return inner_of_outer_[mesh_vertex]; }
  const std::vector<Index>& InnerOfMesh() const { return inner_of_outer_; }
  /// −1 for holes.
  Index Outer(Index inner) const { return outer_of_inner_[inner]; }
  const std::vector<Chunk>& Chunks() const { return chunks_; }

  /// Linearizes all chunks at x, or only those that a cut rebuilt; the gradient stays in its slots.
  /// @return W_I, nJ
  double Linearize(const Workers& workers, const simd::F4* x, bool only_stale);
  /// H p of one chunk into the product slots. @return pᵀ H p of the chunk
  double MultiplyChunk(Index chunk, const simd::F4* p);
  __m128 GradientAt(Index inner) const { return SumSlots(gradient_, inner); }
  __m128 ProductAt(Index inner) const { return SumSlots(product_, inner); }

  /// Lumped volume of each inner vertex, mm³.
  std::vector<double> LumpedVolumes() const;
  /// Connected component of each inner vertex, numbered from 0; holes have one each. @return their
  /// count
  Index Components(std::vector<Index>* component) const;

  /// These vertices and all that tetrahedra connect them with, `rings` times over, ascending.
  std::vector<Index> Surroundings(std::vector<Index> vertices, int rings) const;
  /// All tetrahedra with a corner among these vertices.
  void Extract(const std::vector<Index>& vertices, Excerpt* excerpt) const;
  /// Vertices of these chunks have moved.
  void MarkStale(const std::vector<Index>& chunks);

  /// Rotations of all tetrahedra set to one (a new pose without history).
  void ResetRotations();

 private:
  __m128 SumSlots(const std::vector<simd::F4>& slots, Index inner) const {
    __m128 sum = _mm_setzero_ps();
    for (Index i = slot_begin_[inner]; i < slot_begin_[inner + 1]; ++i)
      sum = _mm_add_ps(sum, simd::Load(slots[slot_[i]]));
    return sum;
  }
  /// Chunks that one of these vertices belongs to, ascending.
  std::vector<Index> ChunksOf(const std::vector<Index>& vertices) const;
  void NumberChunk(const TetMesh& mesh, std::vector<Index>* number_of_inner, Chunk* chunk) const;
  static void MeasureChunk(Chunk* chunk);
  void LayOutSlots();
  void RenumberVertices(const TopologyChange& change, Patch* patch);
  /// @param added new tetrahedra, each with the lane of its parent; the numbers of the others are
  /// those of the new mesh, −1 for those gone
  void RebuildChunk(const TetMesh& mesh, const Material& material,
                    const std::vector<std::pair<Index, Index>>& added, Chunk* chunk) const;

  std::vector<Chunk> chunks_;
  std::vector<Index> inner_of_outer_, outer_of_inner_;
  std::vector<Index> slot_begin_, slot_;  ///< slots of each inner vertex
  std::vector<simd::F4> gradient_, product_;
};

}  // namespace kerf
