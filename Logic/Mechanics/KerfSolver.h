#pragma once

#include <vector>

#include "Mechanics/ElasticSolver.h"
#include "Mechanics/PatchSolver.h"
#include "Mechanics/RecycledModes.h"

namespace kerf {

/// The default solver (`MakeKerfSolver`): Newton steps on the paper's energy (Eq. 1-4), each solved
/// by conjugate gradients with two levels of preconditioning, without a matrix. Positions are those
/// of `ElementField`'s vertices ("inner"), in a frame that follows the organ's rigid motion.
class KerfSolver final : public ElasticSolver {
 public:
  void Reset(const TetMesh& mesh, const Material& material) override;
  void Apply(const TopologyChange& change) override;
  SolveReport Solve(const Springs& springs, const Fixations& fixations, const SolveOptions& options,
                    Points* positions, Points* velocities) override;

 private:
  void Minimize(const Springs& springs, const Fixations& fixations, const SolveOptions& options,
                Points* positions, Points* velocities, SolveReport* report);
  /// What a linear solve (rᵀM⁻¹r at its start and end estimate twice the energy to gain) did.
  struct LinearSolve {
    int iterations = 0;
    double start_nJ = 0.0, end_nJ = 0.0;
    double gap_nJ = 0.0;  ///< bound of what its quadratic model has still to gain
  };

  /// The iteration sees the lower end of the spectrum from above.
  static constexpr double kGapSafety = 1.5;

  /// Vertices per chunk: enough chunks for several threads, large ones where there are many (each
  /// has a sum over the coarse functions of its own).
  Index VertexChunk() const {
    return std::clamp<Index>(field_.VertexCount() / 16 / 64 * 64, 128, 1024);
  }
  Index VertexChunks() const { return (field_.VertexCount() + VertexChunk() - 1) / VertexChunk(); }
  void Reserve(Index vertices);
  void SetRest(const TetMesh& mesh);
  void MeasureComponents();
  /// Apply, among the threads.
  void Follow(const TopologyChange& change);
  /// Inner positions and recycled motions after a change of topology.
  void MapInner(const TopologyChange& change, const ElementField::Patch& patch);
  /// @return whether positions are what the last call returned: then the linearization is valid,
  /// too
  bool Synchronize(const Points& positions);
  void SetAnchors(const Points& positions, const Points* velocities, const SolveOptions& options);
  double Linearize(bool only_stale);
  double AnchorEnergy() const;
  /// residual_ = −gradient of everything, preconditioned. @return rᵀM⁻¹r
  double Residual(double* largest_uN);
  /// smooth_ = D⁻¹ residual_ and Pᵀ residual_ of a vertex chunk. @return its rᵀD⁻¹r
  double SmoothChunk(Index begin, Index end);
  /// coarse_ = (PᵀKP)⁻¹ Pᵀ residual_ when all chunks are smoothed. @return its part of rᵀM⁻¹r
  double CorrectCoarse();
  /// direction_ = M⁻¹ residual_ + beta direction_; `iteration` of the linear solve. @return Σ
  /// anchor |p|²; farthest motion of M⁻¹r
  double Direct(float beta, int iteration, double* farthest_mm);
  /// What a linear solve is to reach.
  struct LinearGoal {
    double energy_nJ = 0.0;  ///< at its start
    double enough_nJ = 0.0;  ///< rᵀM⁻¹r
    double tolerance = 0.0;  ///< of the energy gap, relative
    double floor_nJ = 0.0;   ///< of the energy gap, added to it
    int most_iterations = 0;
  };
  /// Conjugate gradient for step_, from the residual; the first preconditioning and direction are
  /// done.
  LinearSolve SolveLinear(double start_nJ, double anchor_curvature, const LinearGoal& goal);
  /// Bound of the energy still to gain after a linear solve, from what differs between its last
  /// residual and the present one, whose M⁻¹r is direction_. @param start_nJ rᵀM⁻¹r
  double GapAfter(const LinearSolve& solve, double start_nJ) const;
  void MoveBy(double length);
  /// What a cut has just freed is solved for by itself before anything else. @return whether
  /// anything moved
  bool FreeTip();
  /// Brings the preconditioner up to date and, beside its coarse level, frees the tip of a cut.
  /// @return whether anything moved
  bool Prepare();
  /// The coarse level follows the last change of topology.
  void FollowCoarse();
  /// Where a few vertices alone are out of balance, theirs is solved for first. @return whether
  /// anything moved
  bool CorrectPatch();

  TetMesh mesh_;
  Material material_;
  Workers workers_;
  ElementField field_;
  FeatureLoads loads_;
  TwoLevelPreconditioner preconditioner_;
  PatchSolver patch_solver_;
  RecycledModes modes_;
  Vec3 center_ = Vec3::Zero();
  std::vector<Vec3> rest_;                    ///< by inner vertex, relative to the center
  std::vector<Index> component_;              ///< by inner vertex
  std::vector<double> volume_mm3_;            ///< lumped, by inner vertex
  std::vector<double> component_volume_mm3_;  ///< by component
  std::vector<Index> component_vertices_;     ///< by component
  Index components_ = 0;
  Eigen::Isometry3d world_from_inner_ = Eigen::Isometry3d::Identity();
  std::vector<double> x_;          ///< inner positions, 3 per inner vertex
  std::vector<double> anchor_at_;  ///< likewise
  std::vector<float> anchor_;      ///< g/s² by inner vertex
  std::vector<simd::F4> x32_, residual_, solved_residual_, smooth_, direction_, step_;
  std::vector<std::vector<simd::F4>> coarse_parts_;
  std::vector<simd::F4> coarse_residual_, coarse_;
  Points last_positions_;  ///< what the last call returned
  double elastic_nJ_ = 0.0;
  double lowest_ratio_ =
      0.3;  ///< lower end of the spectrum of M⁻¹H as the last linear solve saw it
  ElementField::Patch patch_;   ///< the last change of topology
  bool coarse_behind_ = false;  ///< the coarse level has still to follow it
  std::vector<Index> tip_;  ///< inner vertices that came since the last call, with their origins
  bool renumbered_ = true;
  bool was_cut_ = false;  ///< since the reset: only then are modes looked for
};

}  // namespace kerf
