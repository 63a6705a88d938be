#pragma once

#include <vector>

#include "Mechanics/BlockMatrix.h"
#include "Mechanics/Corotational.h"
#include "Mechanics/FeatureForces.h"

namespace kerf {

/// W_I + W_S of a whole mesh in double precision, with gradient and assembled matrix: what the
/// reference solver steps and what the exact minimizer descends. Positions are 3N vectors, xyz of
/// vertex v at 3v, mm.
class ElasticSystem {
 public:
  enum class Stiffness { Warped, Projected, Exact };

  void Reset(const TetMesh& mesh, const Material& material);
  /// Elements, masses and rotations of kept tetrahedra are carried over; the pattern follows the
  /// new mesh.
  void Apply(const TopologyChange& change);

  const TetMesh& Mesh() const { return mesh_; }
  const Material& GetMaterial() const { return material_; }
  /// Lumped vertex masses: a quarter of each tetrahedron's mass, g.
  const VectorX& Mass() const { return mass_; }

  /// Rotations of all elements at x, warm-started from the last ones.
  void UpdateRotations(const Workers& workers, const VectorX& x);
  /// The following use the rotations of the last UpdateRotations, which must have been at the same
  /// x.
  double ElasticEnergy(const Workers& workers, const VectorX& x) const;
  void ElasticGradient(const Workers& workers, const VectorX& x, VectorX* gradient) const;
  /// ∂²W_I, or its warped or projected form.
  void AssembleElastic(const Workers& workers, const VectorX& x, Stiffness kind);
  const BlockMatrix& Matrix() const { return matrix_; }
  BlockMatrix& Matrix() { return matrix_; }

  /// Adds springs and fixations. @return their energy, nJ; `gradient`, `weights` may be null; the
  /// matrix on request
  double AddFeatureForces(const Springs& springs, const Fixations& fixations, const VectorX& x,
                          VectorX* gradient, bool matrix, VectorX* weights);

 private:
  Corners CornersOf(const VectorX& x, Index tet) const;
  void BuildPattern();

  TetMesh mesh_;
  Material material_;
  std::vector<CorotationalElement> elements_;
  std::vector<Mat3> rotations_;
  VectorX mass_;
  BlockMatrix matrix_;
  /// Upper 10 of the 16 blocks of each element; contributors of each slot: 16·tet + 4a + b.
  std::vector<Mat3> element_blocks_;
  std::vector<Index> contributor_begin_, contributor_;
  std::vector<Index> incident_begin_, incident_;  ///< 4·tet + corner, by vertex
};

VectorX Flatten(const Points& positions);
Points Unflatten(const VectorX& x);

}  // namespace kerf
