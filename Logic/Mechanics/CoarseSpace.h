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
  void Reset(const Workers& workers, const std::vector<Vec3>& rest, const ElementField& field);
  /// How the functions changed: not at all, by some that part of another one's support split off,
  /// or in a way that the factor cannot follow.
  enum class Change { kNone, kGrown, kOther };
  /// Following a change of topology takes three steps: rows of new vertices; what hangs together
  /// within one of the rebuilt chunks (independent of the others); functions whose support fell
  /// apart are split.
  void FollowVertices(const std::vector<Vec3>& rest, const ElementField& field,
                      const ElementField::Patch& patch);
  void FollowChunk(const ElementField& field, Index chunk);
  Change FollowNodes(const ElementField& field, const ElementField::Patch& patch);
  /// What the functions that FollowNodes has split off have in common with others.
  void AssembleGrown(const Workers& workers, const ElementField& field);
  /// PᵀKP, loads and vertex anchors, factored. K is taken at rest: the frame follows the organ's
  /// rigid motion, and what was assembled at different times goes together.
  /// @param anchor g/s² by inner vertex
  void Factor(const Workers& workers, const ElementField& field, const FeatureLoads& loads,
              const std::vector<float>& anchor);
  /// Adds the functions that were split off since to the factor as it is. @return false if they
  /// don't fit: factor anew
  bool Extend(const FeatureLoads& loads, const std::vector<float>& anchor);
  /// So much was added that it is worth factoring anew in a call that has no cut to follow.
  bool IsLong() const;

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
  /// Splits the flagged nodes by connectivity. @param is_old by inner vertex: its row is in use;
  /// @param changed those of them whose row changed
  Change Split(const ElementField& field, const std::vector<char>& flagged_nodes,
               const std::vector<char>& is_old, std::vector<Index>* changed);
  Index NewFunction(Index node, Index parent);
  void OrderFunctions();
  /// What loads make of the coarse functions: weight by function.
  struct LoadRow {
    int count = 0;
    Index function[16];
    float weight[16];
    /// Of two of them, row by row.
    void Block(const FeatureLoads::Load& load, int s, int t, float block[9]) const;
  };
  std::vector<LoadRow> LoadRows(const FeatureLoads& loads) const;
  std::vector<float> LumpedAnchors(const std::vector<float>& anchor) const;
  using Lanes = std::vector<std::pair<Index, Index>>;  ///< chunk and lane of tetrahedra
  struct CellLanes {
    Index cell;
    Lanes lanes;
  };
  /// Tetrahedra with one of their first `corners` corners where `vertices` (by inner vertex) is
  /// set, by cells. A tetrahedron belongs to the cell of its first corner.
  std::vector<CellLanes> LanesAt(const ElementField& field, const std::vector<char>& vertices,
                                 int corners) const;
  void AssembleStale(const Workers& workers, const ElementField& field);
  /// Pairs with a wanted function.
  Part AssembleCell(const ElementField& field, const Lanes& lanes,
                    const std::vector<char>& wanted) const;

  double cell_mm_ = 1.0;
  Vec3 origin_ = Vec3::Zero();
  Eigen::Vector3i size_ = Eigen::Vector3i::Zero();  ///< lattice nodes along each axis
  std::vector<Row> rows_;
  std::vector<Index> cell_;  ///< lattice cell of each inner vertex, by its lowest node
  std::vector<Index> node_;  ///< lattice node of each row entry, 4 per inner vertex, −1 = none
  std::vector<Index> node_of_function_;  ///< −1 = unused
  std::vector<std::vector<Index>> functions_of_node_;
  std::vector<Index> position_;  ///< first of three unknowns of each function in the factor
  /// Functions split off since the factor was made and those that they were part of then (−1: all
  /// others). In the factor such a parent still stands for its whole support, the others follow at
  /// its end: what is factored of the parents stays right.
  std::vector<Index> parent_;
  std::vector<Index> grown_;                       ///< the split off, in this order
  std::size_t extended_ = 0;                       ///< of them in the factor
  std::vector<std::vector<std::uint16_t>> links_;  ///< by chunk
  std::vector<Part> parts_;                        ///< by cell
  std::vector<char> stale_;                        ///< by cell: its part is out of date
  std::vector<CellLanes> grown_cells_;  ///< all tetrahedra that functions split off reach
  std::vector<Part> grown_parts_;       ///< see AssembleGrown
  BandCholesky factor_;
  mutable std::vector<float> work_;
};

}  // namespace kerf
