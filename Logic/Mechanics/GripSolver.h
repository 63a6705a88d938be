#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <vector>

#include "Mechanics/ElasticSolver.h"

namespace kerf {

/// How far an equilibrium is taken.
struct GripOptions {
  int max_newton_steps = 20;
  double tolerance_mm = 1e-4;  ///< largest vertex motion of the last Newton step
  int threads = 0;             ///< 0 = all
};

struct GripReport {
  bool converged = false;
  int newton_steps = 0;
  double elastic_energy_uJ = 0.0;
};

/// An organ held by grips: sets of vertices that move as rigid bodies, all the rest free of load
/// and in equilibrium (min W_I of Eq. 3 under these positions). The motions of the grips are the
/// unknowns of whoever fits them to tracked features; this gives the shape for given motions, and
/// how points move with them.
///
/// Double precision; one direct factorization serves the Newton steps as a predictor, and all
/// sensitivities.
class GripSolver {
 public:
  GripSolver();
  ~GripSolver();
  /// @throws UsageError on a bad material or an inverted tetrahedron
  void Reset(const TetMesh& mesh, const Material& material);
  /// The mesh was cut; grips follow to all copies of their vertices.
  void Apply(const TopologyChange& change);
  /// @param grips vertices of each grip. @throws UsageError: no such vertex, a vertex in two grips,
  /// an empty grip
  void SetGrips(std::vector<std::vector<Index>> grips);
  const std::vector<std::vector<Index>>& Grips() const;

  /// Equilibrium with grip g at motions[g] · rest. @param positions in: where to start (a pose near
  /// it), out: N×3, mm
  GripReport Solve(const std::vector<Eigen::Isometry3d>& motions, const GripOptions& options,
                   Points* positions);
  /// dp/dq of embedded points at the equilibrium of the last Solve. Parameters of grip g are
  /// columns 6g…6g+5: a translation (mm) and a rotation vector (rad) about the grip's present
  /// centroid, both in the frame of the positions, applied after its motion. @return 3M×6G
  Eigen::MatrixXd Sensitivities(const Embedding& points) const;
  /// `motion` after the parameter change `step` (translation, rotation vector about its centroid)
  /// of grip g.
  Eigen::Isometry3d Moved(Index grip, const Eigen::Isometry3d& motion,
                          const Eigen::Matrix<double, 6, 1>& step) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace kerf
