#pragma once

#include <optional>

#include "Core/Types.h"
#include "Cutting/CutStructure.h"
#include "Mechanics/ElasticSolver.h"

namespace kerf {

enum class Method {
  Kerf,      ///< the default: needs no per-study setting
  Reference  ///< the paper's method, for comparison
};

/// The most that the solver does in one frame: what has not settled then goes on in the next, from
/// where it is. Cuts and leaps need it. Less in a frame with a cut: Step.cxx.
constexpr int kFrameNewtonSteps = 2, kFrameIterations = 28;

/// Everything that steers one registration. The defaults are Kerf's; `ReferenceOptions()` gives the
/// paper's.
struct MethodOptions {
  Method method = Method::Kerf;
  bool cutting = true;
  bool hold_search = false;  ///< what a search for better cuts found is not taken over yet
  bool hold_cuts = false;  ///< detected cuts are proposals (ModelCut::held) until they are accepted

  // Elasticity and springs, Eq. (2)–(5)
  Material material;
  double spring_factor_mm =
      10.0;  ///< k_l = spring_factor · E: 10 mm is LIMITS' floor; the paper's is 1 mm
  std::optional<double>
      spring_g_s2;  ///< `--spring`: k_l itself, g/s² (10⁻³ N/m); overrides the factor
  double along_factor =
      0.1;  ///< stiffness along the line of sight relative to across (depth gauge)
  double robust_scale_mm = 5.0;  ///< Geman–McClure; 0 = quadratic
  double silhouette_factor =
      0.5;  ///< stiffness at the outline relative to a feature's; 0 = the paper (none)
  int silhouette_reach_px = 30;  ///< how far from the model's outline the organ's is looked for
  bool grips = true;             ///< explain the tracks by few rigid grips and take depth from them
  int steps_per_frame = 1;       ///< repeats of steps [2]–[8] of Fig. 1 with one frame
  SolveOptions solve = FrameSolve();

  // Cut detection, Eq. (11)
  double neighbour_radius_mm = 15.0;   ///< r_PF⁰
  double tau = 8.0;                    ///< τ: outliers have μ > τ μ_∅
  int outliers = 8;                    ///< n
  double cut_radius_mm = 7.0;          ///< r_pC
  double noise_floor_mm = 0.5;         ///< μ below it is never an outlier (tracking noise at rest)
  std::optional<Vec3> extrusion;       ///< LPS unit vector into the tissue; none = camera direction
  std::optional<double> cut_depth_mm;  ///< limited depth; none = through
  StructureCutMode structure_mode = StructureCutMode::Split;

  int wanted_features = 225;
  double SpringStiffness_g_s2() const;
  static SolveOptions FrameSolve();
  /// @throws UsageError naming the option out of range
  void Validate() const;
};

/// The paper's configuration: isotropic springs k = E, implicit Euler, Eq. (12).
MethodOptions ReferenceOptions();

}  // namespace kerf
