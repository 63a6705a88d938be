#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "Mechanics/ElementField.h"
#include "Mechanics/FeatureForces.h"

namespace kerf {

/// Springs and fixations as the fast solver sees them: each pulls at up to four inner vertices.
/// Positions are in the solver's inner frame, which follows the rigid motion of the organ; targets
/// stay in the world.
class FeatureLoads {
 public:
  struct Load {
    Index vertex[4];
    float weight[4];
    float matrix[6];    ///< xx yy zz yz xz xy of k w Q in the inner frame, g/s²
    simd::F4 gradient;  ///< k w Q d in the inner frame, µN
    double stiffness;   ///< trace of the matrix / 3
    simd::F4 Times(const simd::F4& d) const {
      const float* m = matrix;
      return {m[0] * d.x + m[5] * d.y + m[4] * d.z, m[5] * d.x + m[1] * d.y + m[3] * d.z,
              m[4] * d.x + m[3] * d.y + m[2] * d.z, 0.0f};
    }
  };

  /// The problem of this call. Sorted anew only if the attachment changed or `renumbered`.
  void Set(const Springs& springs, const Fixations& fixations, const TetMesh& mesh,
           const ElementField& field, bool renumbered);
  /// Energy (nJ), gradients and matrices at inner positions x (3 per inner vertex).
  double Evaluate(const Eigen::Isometry3d& world_from_inner, const std::vector<double>& x);
  /// Moves the frame as a rigid body to where the loads pull it least, elastic energy unchanged:
  /// the rigid part of Eq. (5). Evaluates at the result. @return energy, nJ
  double FitRigid(const std::vector<double>& x, Eigen::Isometry3d* world_from_inner);

  /// What the springs hold that are drawn out by this much, nJ; fixations are not counted: they are
  /// as stiff as they have to be.
  double EnergyAt(double distance_mm) const;

  const std::vector<Load>& Loads() const { return loads_; }
  const Eigen::VectorXd& SpringWeights() const { return spring_weights_; }
  /// Adds the loads' part of the gradient / of H p to vertex sums of [begin, end). `values`: one
  /// per load.
  template <class Add>
  void ForVertices(Index begin, Index end, const Add& add) const {
    auto entry = std::lower_bound(entries_.begin(), entries_.end(), begin,
                                  [](const Entry& e, Index v) { return e.vertex < v; });
    for (; entry != entries_.end() && entry->vertex < end; ++entry)
      add(entry->vertex, entry->load, entry->weight);
  }
  /// Matrix · (interpolated p) of all loads. @return pᵀ K p of the loads
  double Multiply(const simd::F4* p);
  const std::vector<simd::F4>& Products() const { return products_; }

 private:
  struct Entry {
    Index vertex, load;
    float weight;
  };
  /// World position, residual state of one load.
  SpringState EvaluateOne(std::size_t load, const Vec3& world) const;
  Vec3 InnerPosition(const Load& load, const std::vector<double>& x) const;

  const Springs* springs_ = nullptr;
  const Fixations* fixations_ = nullptr;
  std::vector<Index> attached_tet_, attached_vertex_;
  Weights4 attached_weights_;
  std::vector<Load> loads_;
  std::vector<Entry> entries_;
  std::vector<simd::F4> products_;
  Eigen::VectorXd spring_weights_;
};

}  // namespace kerf
