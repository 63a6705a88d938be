#pragma once

#include <Eigen/Geometry>
#include <atomic>
#include <memory>
#include <vector>

#include "Core/Camera.h"
#include "Mechanics/ElasticSolver.h"
#include "Registration/Targets.h"

namespace kerf {

/// A held part of the organ: the vertices whose rest position lies at least `from_mm` along `axis`.
struct GripRegion {
  Vec3 axis = Vec3::UnitX();  ///< unit
  double from_mm = 0.0;
  double end_mm = 0.0;  ///< where the organ ends along the axis
  bool Holds(const Vec3& rest) const { return rest.dot(axis) >= from_mm; }
};

/// What explains the tracks by few rigidly moving grips on an otherwise unloaded organ, in
/// equilibrium (minimum of Eq. 3 with the held vertices where the grips have them). One camera sees
/// no depth; who knows where the loads act, knows it. Parameters of grip g are 6g…6g+5: a
/// translation (mm) and a rotation vector (rad) about the grip's present centre.
struct GripFit {
  std::vector<GripRegion> regions;                    ///< at rest; none: not begun
  std::vector<Eigen::Isometry3d> motions;             ///< of each, from rest
  Points positions;                                   ///< N×3, the organ under them, mm
  Eigen::MatrixXd sensitivities;                      ///< 3F×6G, of the features' positions
  std::vector<std::shared_ptr<const Points>> fields;  ///< 6G, the same of all vertices, N×3: starts
                                                      ///< for the next solves; none: not known
  bool settled = false;       ///< `positions` are the equilibrium
  bool torn = false;          ///< the model was cut since the last update
  bool waited = false;        ///< in the last update the motions stayed as they were
  int next_column = 0;        ///< the sensitivity that is renewed next
  int frames_to_renewal = 0;  ///< until then the sensitivities stay; below 0: one is due
  double lambda = 1e-2;       ///< damping of the next step
  double cost_mm2 = 0.0;      ///< robust mean square across the lines of sight, and of depth
  double residual_mm = 0.0;   ///< robust rms across the lines of sight
  double volume_mm3 = 0.0;    ///< of the organ at rest; cuts do not change it
  double strain2 = 0.0;       ///< mean squared strain of the organ
  double trust = 0.0;         ///< in its depth; 0: not believed … 1
  double trust_across = 0.0;  ///< in what it says across the lines of sight
};

struct GripFitOptions {
  double cap_share = 0.14;       ///< of the organ's length that a grip at either end holds
  double robust_scale_mm = 3.0;  ///< Geman–McClure; 1 mm loses the tracks after a jump
  double depth_weight = 1e-3;  ///< of (depth − depth at rest)² beside the squares across: a flat
                               ///< organ's stretch is else explained as approach
  double turn_weight_mm2 = 2.0;  ///< of a grip's squared rotation from rest (rad²) beside the mean
                                 ///< square across: a stretched band hardly tells how its ends are
                                 ///< turned, and a turn of 100° once made up for the law's error
  double trust_gained = 0.1;     ///< at most, a frame: the overlay must not leap
  double trust_lost = 0.25;
  int steps = 1;             ///< damped Gauss–Newton steps a frame
  int newton_steps = 2;      ///< of one equilibrium at most; the rest is left to the next
  int most_iterations = 24;  ///< of its linear solves, likewise (0: 80 a step); where the organ has
                             ///< to settle first, a trial has what that left, or half of it
  const std::atomic<bool>* given_up = nullptr;  ///< true: ends before the next equilibrium
  int renewed_columns = 1;                      ///< sensitivities measured anew at a time, in turn
  int renewal_frames = 6;     ///< from one time to the next, and as many more where settling takes
                              ///< more than half of the iterations; each while some are unknown
  double believed_mm = 0.38;  ///< residual up to which the fit is believed fully
  double linear_strain2 = 0.15;     ///< mean squared strain up to which the law is believed
  double nonlinear_strain2 = 0.25;  ///< and from which on not at all
  double explained_share = 0.97;    ///< of the features within the robust scale: full belief
  double unexplained_share = 0.90;  ///< and none
  double disbelieved_mm = 0.60;     ///< and from which on not at all
  double believed_across_mm = 1.0;  ///< the same for what it says across the lines of sight: a band
                                    ///< stretched by 90 % leaves 0.9 mm by the law's width alone
  double disbelieved_across_mm = 1.6;
};

/// Grips at both ends of the organ's long axis, at rest. @param solver set up with `mesh`; its own
GripFit BeginGrips(const TetMesh& mesh, const BoundFeatures& bound, const Material& material,
                   const GripFitOptions& options, ElasticSolver* solver);

/// One frame: the motions are corrected by damped Gauss–Newton steps on what lies between the
/// model's features and their lines of sight; where the model has been cut (SettlesOnly) it is
/// brought into equilibrium alone. `solver` and `fit` have followed every cut of `mesh`.
/// @param usable one flag per feature
void UpdateGrips(const TetMesh& mesh, const Material& material, const BoundFeatures& bound,
                 const Pixels& pixels, const std::vector<char>& usable, const CameraModel& camera,
                 const GripFitOptions& options, ElasticSolver* solver, GripFit* fit);

/// Whether the next update leaves the motions as they are and brings the organ into equilibrium
/// alone: that is work enough for a frame in which it was cut, but not in one after the other.
/// (What a search found is such a frame, too: Step.)
inline bool SettlesOnly(const GripFit& fit) { return fit.torn && !fit.waited; }

/// The organ bent smoothly from grip to grip, not yet in equilibrium: a start that no cut has torn.
Points BentByGrips(const GripFit& fit, const Points& rest);

/// The same grips with each held part as long as `factor` times what it was, its motion kept; the
/// sensitivities are those before.
GripFit Regripped(const GripFit& fit, const std::vector<double>& factors);

/// `fit`, begun from `then`, with the motion that the grips have made since, up to `now`.
/// @param rest of the mesh that `fit` belongs to
GripFit MovedOn(GripFit fit, const GripFit& then, const GripFit& now, const Points& rest);

/// The mesh was cut: the organ under the grips is, and so it is not in equilibrium any more.
void FollowCut(const TopologyChange& change, GripFit* fit);

/// Vertices in a region.
std::vector<Index> VerticesIn(const GripRegion& region, const Points& rest);

}  // namespace kerf
