#pragma once

#include <vector>

#include "Mechanics/BandCholesky.h"
#include "Mechanics/FeatureLoads.h"

namespace kerf {

/// The coarse level of the preconditioner: a lattice over the rest shape, linear interpolation on
/// the simplices of its cells (exact for rigid and uniformly strained shapes), Galerkin matrix
/// PᵀKP, factored directly.
///
/// A lattice node carries one function for each connected part of the vertices that it reaches, so
/// a cut through its support splits it: the two sides of an open cut move apart in the coarse
/// space, too.
class CoarseSpace {
 public:
  /// Interpolation row of a vertex: x_v += Σ_k weight_k · c[function_k].
  struct Row {
    float weight[4] = {};
    std::uint16_t function[4] = {};
  };

  /// @param rest rest positions by inner vertex
  void Reset(const std::vector<Vec3>& rest, const ElementField& field);
  /// Rows of new vertices; functions whose support fell apart are split. @return whether that
  /// changed the functions; then `stale` has the cells whose Galerkin part is out of date
  bool Apply(const Workers& workers, const std::vector<Vec3>& rest, const ElementField& field,
             const ElementField::Patch& patch, std::vector<Index>* stale);
  /// Galerkin parts of these cells (all: `Cells()`) at the rotations of the last linearization.
  void Assemble(const Workers& workers, const ElementField& field, const std::vector<Index>& cells);
  Index Cells() const { return static_cast<Index>(parts_.size()); }
  /// Sum of all parts, loads and vertex anchors, factored. @param anchor g/s² by inner vertex
  void Factor(const FeatureLoads& loads, const std::vector<float>& anchor);

  /// Functions, unused ones included: the size of the arrays below.
  Index FunctionCount() const { return static_cast<Index>(node_of_function_.size()); }
  const Row& At(Index inner) const { return rows_[inner]; }
  /// c ← (PᵀKP)⁻¹ c
  void Solve(simd::F4* c) const;

 private:
  struct Pair {
    std::uint16_t row, column;  ///< functions
    float block[9];
  };
  /// What the tetrahedra of a cell add to PᵀKP: each pair of functions once.
  struct Part {
    std::vector<std::uint16_t> functions;
    std::vector<Pair> pairs;
  };
  void SetRow(const Vec3& rest, Index inner);
  /// For each row entry (4 per vertex of the chunk) one that it is connected with at its node, the
  /// same for all that are, by tetrahedra of the chunk.
  std::vector<std::uint16_t> LinkChunk(const ElementField::Chunk& chunk) const;
  /// Splits the flagged nodes by connectivity. @param is_old by inner vertex: its row is in use.
  /// @return those of them whose row changed; `altered`: a node has other functions than before
  std::vector<Index> Split(const ElementField& field, const std::vector<char>& flagged_nodes,
                           const std::vector<char>& is_old, bool* altered);
  void OrderFunctions();
  /// Cells of the tetrahedra with a corner where `vertices` (by inner vertex) is set. A tetrahedron
  /// belongs to the cell of its first corner.
  std::vector<Index> CellsAt(const ElementField& field, const std::vector<char>& vertices) const;
  /// @param lanes chunk and lane of each tetrahedron
  void AssembleCell(const ElementField& field, const std::vector<std::pair<Index, Index>>& lanes,
                    Part* part) const;

  double cell_mm_ = 1.0;
  Vec3 origin_ = Vec3::Zero();
  Eigen::Vector3i size_ = Eigen::Vector3i::Zero();  ///< lattice nodes along each axis
  std::vector<Row> rows_;
  std::vector<Index> cell_;  ///< lattice cell of each inner vertex, by its lowest node
  std::vector<Index> node_;  ///< lattice node of each row entry, 4 per inner vertex, −1 = none
  std::vector<Index> node_of_function_;  ///< −1 = unused
  std::vector<std::vector<Index>> functions_of_node_;
  std::vector<Index> position_;  ///< of each function in the factor
  Index used_ = 0;
  std::vector<std::vector<std::uint16_t>> links_;  ///< by chunk
  std::vector<Part> parts_;                        ///< by cell
  BandCholesky factor_;
  mutable std::vector<float> work_;
};

}  // namespace kerf
