#pragma once

#include <memory>
#include <string>
#include <vector>

#include "Core/Embedding.h"
#include "Core/TetMesh.h"
#include "Core/TopologyChange.h"
#include "Core/Types.h"

namespace kerf {

/// Isotropic material of corotational linear elasticity, Eq. (1)–(3). E in kPa at the surface; Lamé
/// coefficients in Pa = g/(mm·s²) inside.
struct Material {
  double young_kPa = 15.0;
  double poisson = 0.45;                 ///< 0 ≤ ν < 0.5
  double tumour_stiffness_factor = 3.0;  ///< E of Label::Tumour tetrahedra relative to the organ's
  double density_g_mm3 = 1.06e-3;
  double Mu_Pa(std::uint8_t region) const;
  double Lambda_Pa(std::uint8_t region) const;
  /// @throws UsageError naming the parameter out of range
  void Validate() const;
};

/// Feature springs, Eq. (4): W_S = Σ_l ½ k_l ‖p_l(P_V) − p_l¹‖², optionally anisotropic (a ray
/// constrains two directions, not three) and robust.
struct Springs {
  Embedding at;               ///< N feature points P_F
  Points targets;             ///< N×3, P_F¹, mm
  Eigen::VectorXd stiffness;  ///< N, k_l, g/s² (10⁻³ N/m); 0 = inactive
  Points directions;          ///< N×3 unit lines of sight, or 0 rows for isotropic springs
  double along_factor = 1.0;  ///< stiffness along the direction relative to k_l (0 = pure ray)
  double robust_scale_mm =
      0;  ///< Geman–McClure scale on the constrained residual; 0 = quadratic (the paper)
};

/// Soft positional constraints on vertices (ligaments, fixation on request, grips). Empty by
/// default: the paper needs no boundary conditions.
struct Fixations {
  std::vector<Index> vertices;
  Points targets;  ///< same rows
  double stiffness_g_s2 = 0.0;
};

/// How the solver is run in one call. Iterations are numbers, never the clock (determinism).
struct SolveOptions {
  int steps = 1;               ///< reference: implicit Euler steps
  int max_newton_steps = 0;    ///< Kerf: most Newton steps (0 = 12)
  int most_iterations = 0;     ///< Kerf: most CG iterations of a call, all steps (0 = 80 a step)
  int max_cg_iterations = 25;  ///< reference: per linear solve (0 = until tolerance)
  double time_step_s = 0.04;   ///< implicit Euler step (reference; Kerf: only with `inertia`)
  bool inertia = false;        ///< Kerf: add M/h² and the velocities, as the reference always does
  double tolerance = 1e-3;     ///< relative energy gap (Kerf); relative CG residual (reference)
  int threads = 0;             ///< 0 = those that the caller works with
};

struct SolveReport {
  bool converged = false;
  int steps = 0, cg_iterations = 0;
  double elastic_energy_uJ =
      0.0;  ///< W_I, Eq. (3), µJ; inside the solvers energies are in g·mm²/s² = nJ
  double spring_energy_uJ = 0.0;   ///< W_S, Eq. (4), fixations included, µJ
  double gradient_norm = 0.0;      ///< ‖∂(W_I + W_S)/∂P_V‖∞, g·mm/s² = µN
  Eigen::VectorXd spring_weights;  ///< robust weight of each spring, 1 where quadratic
};

/// Minimizes W_I + W_S (Eq. 5) over vertex positions. Implementations: the paper's implicit Euler
/// with conjugate gradient (reference), Newton-PCG (Kerf). Deterministic: the same calls give the
/// same bits for every thread count.
class ElasticSolver {
 public:
  virtual ~ElasticSolver() = default;
  /// A new problem; forgets everything. @throws UsageError on a bad material
  virtual void Reset(const TetMesh& mesh, const Material& material) = 0;
  /// The mesh was cut: carry caches over from the provenance. `change.mesh` is the mesh from now
  /// on.
  virtual void Apply(const TopologyChange& change) = 0;
  /// @param positions in: P_V^t, out: P_V^{t+1}, N×3 mm; @param velocities likewise, mm/s
  /// (untouched without inertia)
  virtual SolveReport Solve(const Springs& springs, const Fixations& fixations,
                            const SolveOptions& options, Points* positions, Points* velocities) = 0;
};

/// The paper's method: implicit Euler, conjugate gradient, one matrix assembly per step.
std::unique_ptr<ElasticSolver> MakeReferenceSolver();
/// The default: matrix-free Newton with a two-level preconditioned conjugate gradient
/// (docs/performance.md).
std::unique_ptr<ElasticSolver> MakeKerfSolver();

}  // namespace kerf
