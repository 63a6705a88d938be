#include "Mechanics/KerfSolver.h"

#include <cmath>

#include "Core/Errors.h"

namespace kerf {
namespace {

constexpr int kMaxNewtonSteps = 12;
constexpr int kMaxCgIterations = 80;
constexpr int kMaxHalvings = 10;
constexpr double kVertexToleranceMm = 0.05;
/// Of the estimate of what vertices are off.
constexpr double kErrorSafety = 1.0;
/// Part of the tolerance that a linear solve may leave. The vertices need more of it the lower the
/// spectrum reaches, by the root of that: their tolerance, not the energy's, is the narrow one.
constexpr double kLinearPart = 0.07, kEnergyPart = 0.4, kFineError = 0.2;
/// Where the energy is good enough already, it is the vertices that are not: a linear solve is to
/// gain something all the same.
constexpr double kLeastReduction = 0.1;
/// Solves for a patch between two linear solves at most.
constexpr int kMaxPatchSolves = 2;
/// Motion below which nothing is worth solving, whatever the relative energy gap.
constexpr double kStillMm = 0.0003;
/// Total stiffness of the proximal anchors of a component, relative to its springs
/// or, if that is less, to E·V^(1/3): they hold what
/// no spring holds (the depth along pure rays, turns about a line) and shift the rest by a
/// thousandth of its motion in a call.
constexpr double kAnchorFraction = 1e-3;
/// A component without any spring is held by the inertia of a time step of this length.
constexpr double kFreeTimeStep_s = 0.04;
/// Memory is at hand for so many vertices more, a part of those at the start: what a cut adds.
constexpr Index kRoomToGrow = 8;

Eigen::Map<Vec3> At(std::vector<double>* positions, Index v) {
  return Eigen::Map<Vec3>(positions->data() + 3 * v);
}

}  // namespace

void KerfSolver::Reset(const TetMesh& mesh, const Material& material) {
  material.Validate();
  mesh_ = mesh;
  material_ = material;
  field_.Reset(mesh, material);
  center_ = Vec3::Zero();
  if (mesh.VertexCount() > 0) center_ = mesh.rest.colwise().mean().transpose();
  SetRest(mesh);
  MeasureComponents();
  preconditioner_.Reset(workers_, rest_, field_);
  x_.clear();
  last_positions_.resize(0, 3);
  lowest_ratio_ = 0.3;
  renumbered_ = true;
  modes_.Clear();
  tip_.clear();
  was_cut_ = coarse_behind_ = false;
  Reserve(field_.VertexCount() + field_.VertexCount() / kRoomToGrow);
}

void KerfSolver::Reserve(Index vertices) {
  for (std::vector<simd::F4>* values :
       {&x32_, &residual_, &solved_residual_, &smooth_, &direction_, &step_})
    values->assign(vertices, {});
  modes_.Reserve(vertices);
}

void KerfSolver::SetRest(const TetMesh& mesh) {
  rest_.assign(field_.VertexCount(), Vec3::Zero());
  for (Index v = 0; v < mesh.VertexCount(); ++v)
    rest_[field_.Inner(v)] = mesh.rest.row(v).transpose() - center_;
}

void KerfSolver::MeasureComponents() {
  components_ = field_.Components(&component_);
  volume_mm3_ = field_.LumpedVolumes();
  component_volume_mm3_.assign(components_, 0.0);
  component_vertices_.assign(components_, 0);
  for (Index v = 0; v < field_.VertexCount(); ++v) {
    component_volume_mm3_[component_[v]] += volume_mm3_[v];
    if (field_.Outer(v) >= 0) ++component_vertices_[component_[v]];
  }
}

void KerfSolver::Apply(const TopologyChange& change) {
  if (!change.changed) return;
  workers_.Run([&] { Follow(change); });
}

void KerfSolver::Follow(const TopologyChange& change) {
  FollowCoarse();
  patch_ = field_.Apply(workers_, change.mesh, material_, change);
  const auto follow_rest = [&] {
    SetRest(change.mesh);
    preconditioner_.FollowVertices(workers_, rest_, field_, patch_);
  };
  const auto follow_vertices = [&] {
    MapInner(change, patch_);
    MeasureComponents();
    mesh_ = change.mesh;
    // The caller maps its positions in the same way, so the next call recognizes the pose.
    if (last_positions_.rows() > 0) last_positions_ = change.MapVertexField(last_positions_);
  };
  workers_.Both(follow_rest, follow_vertices);
  tip_.insert(tip_.end(), patch_.new_vertices.begin(), patch_.new_vertices.end());
  tip_.insert(tip_.end(), patch_.origins.begin(), patch_.origins.end());
  was_cut_ = renumbered_ = coarse_behind_ = true;
}

void KerfSolver::FollowCoarse() {
  if (coarse_behind_) preconditioner_.FollowCoarse(workers_, field_, patch_);
  coarse_behind_ = false;
}

bool KerfSolver::Prepare() {
  const auto follow_coarse = [&] {
    FollowCoarse();
    preconditioner_.UpdateCoarse(workers_, field_, loads_, anchor_);
  };
  bool moved = false;
  if (tip_.empty()) {
    follow_coarse();
  } else {
    // The tip takes one thread and the blocks of the diagonal alone.
    preconditioner_.UpdateDiagonal(workers_, field_, loads_);
    workers_.Both([&] { moved = FreeTip(); }, follow_coarse);
  }
  preconditioner_.UpdateDiagonal(workers_, field_, loads_);
  return moved;
}

void KerfSolver::MapInner(const TopologyChange& change, const ElementField::Patch& patch) {
  modes_.Apply(field_, change, patch);
  if (x_.empty()) return;
  // All at once: a new vertex may have the place of one that another new one stems from.
  std::vector<Vec3> at(patch.new_vertices.size(), Vec3::Zero());
  for (std::size_t i = 0; i < at.size(); ++i)
    for (int k = 0; k < 4; ++k)
      at[i] += change.vertex_weights(field_.Outer(patch.new_vertices[i]), k) *
               At(&x_, patch.parents[i][k]);
  x_.resize(3 * static_cast<std::size_t>(field_.VertexCount()), 0.0);
  for (std::size_t i = 0; i < at.size(); ++i) At(&x_, patch.new_vertices[i]) = at[i];
}

bool KerfSolver::Synchronize(const Points& positions) {
  const Index n = field_.VertexCount();
  x32_.resize(n);
  residual_.resize(n);
  smooth_.resize(n);
  solved_residual_.resize(n);
  direction_.resize(n);
  step_.resize(n);
  const bool same = last_positions_.rows() == positions.rows() && last_positions_ == positions;
  if (!same) {
    // A pose of the caller's: the frame is the rigid motion nearest to it, so that inner positions
    // stay near the rest.
    x_.assign(3 * static_cast<std::size_t>(n), 0.0);
    const Vec3 mean = positions.colwise().mean().transpose();
    Mat3 covariance = Mat3::Zero();
    for (Index v = 0; v < mesh_.VertexCount(); ++v)
      covariance += (positions.row(v).transpose() - mean) * rest_[field_.Inner(v)].transpose();
    const double size = covariance.norm();
    world_from_inner_.linear() =
        size > 0.0 ? PolarRotation(covariance * (3.0 / size)) : Mat3(Mat3::Identity());
    world_from_inner_.translation() = mean;
    const Eigen::Isometry3d inner_from_world = world_from_inner_.inverse();
    for (Index v = 0; v < mesh_.VertexCount(); ++v)
      At(&x_, field_.Inner(v)) = inner_from_world * positions.row(v).transpose();
    field_.ResetRotations();
    modes_.Clear();
    tip_.clear();
  }
  return same;
}

double KerfSolver::Linearize(bool only_stale) {
  workers_.ForChunks(field_.VertexCount(), VertexChunk(), [&](Index begin, Index end) {
    for (Index v = begin; v < end; ++v)
      x32_[v] = {static_cast<float>(x_[3 * v]), static_cast<float>(x_[3 * v + 1]),
                 static_cast<float>(x_[3 * v + 2]), 0.0f};
  });
  return field_.Linearize(workers_, x32_.data(), only_stale);
}

void KerfSolver::SetAnchors(const Points& positions, const Points* velocities,
                            const SolveOptions& options) {
  const Index n = field_.VertexCount();
  anchor_at_ = x_;
  anchor_.assign(n, 0.0f);
  const bool inertia = options.inertia && options.time_step_s > 0.0;
  const double h = inertia ? options.time_step_s : kFreeTimeStep_s;
  std::vector<double> pull(components_, 0.0), anchor(components_);
  for (const FeatureLoads::Load& load : loads_.Loads())
    pull[component_[load.vertex[0]]] += load.stiffness;
  for (Index c = 0; c < components_; ++c) {
    const double elastic = 1e3 * material_.young_kPa * std::cbrt(component_volume_mm3_[c]);
    anchor[c] =
        kAnchorFraction * std::min(pull[c], elastic) / std::max<Index>(1, component_vertices_[c]);
  }
  for (Index v = 0; v < n; ++v) {
    if (field_.Outer(v) < 0) continue;
    const Index c = component_[v];
    const bool by_mass = inertia || pull[c] == 0.0;
    const double mass = material_.density_g_mm3 * volume_mm3_[v];
    anchor_[v] = static_cast<float>(by_mass ? std::max(mass / (h * h), 1e-6) : anchor[c]);
  }
  if (!inertia || !velocities || velocities->rows() != positions.rows()) return;
  const Eigen::Isometry3d inner_from_world = world_from_inner_.inverse();
  for (Index v = 0; v < mesh_.VertexCount(); ++v)
    At(&anchor_at_, field_.Inner(v)) =
        inner_from_world *
        Vec3((positions.row(v) + options.time_step_s * velocities->row(v)).transpose());
}

double KerfSolver::AnchorEnergy() const {
  return workers_.SumChunks(field_.VertexCount(), VertexChunk(), [&](Index begin, Index end) {
    double sum = 0.0;
    for (Index v = begin; v < end; ++v)
      for (int i = 0; i < 3; ++i) {
        const double d = x_[3 * v + i] - anchor_at_[3 * v + i];
        sum += 0.5 * static_cast<double>(anchor_[v]) * d * d;
      }
    return sum;
  });
}

void KerfSolver::MoveBy(double length) {
  workers_.ForChunks(field_.VertexCount(), VertexChunk(), [&](Index begin, Index end) {
    for (Index v = begin; v < end; ++v) {
      x_[3 * v] += length * static_cast<double>(step_[v].x);
      x_[3 * v + 1] += length * static_cast<double>(step_[v].y);
      x_[3 * v + 2] += length * static_cast<double>(step_[v].z);
    }
  });
}

SolveReport KerfSolver::Solve(const Springs& springs, const Fixations& fixations,
                              const SolveOptions& options, Points* positions, Points* velocities) {
  ValidateSprings(springs, mesh_.TetCount());
  ValidateFixations(fixations, mesh_.VertexCount());
  if (positions->rows() != mesh_.VertexCount() || !positions->allFinite())
    throw UsageError("positions and mesh differ in vertex count, or a position is not finite");
  SolveReport report;
  report.spring_weights = Eigen::VectorXd::Ones(springs.at.Size());
  if (mesh_.TetCount() == 0) return report;
  workers_.Use(options.threads);
  workers_.Run([&] { Minimize(springs, fixations, options, positions, velocities, &report); });
  return report;
}

void KerfSolver::Minimize(const Springs& springs, const Fixations& fixations,
                          const SolveOptions& options, Points* positions, Points* velocities,
                          SolveReport* report) {
  const bool same = Synchronize(*positions);
  loads_.Set(springs, fixations, mesh_, field_, renumbered_);
  renumbered_ = false;
  // With inertia the rigid motion has its own dynamics; without, its minimum is found beforehand.
  double loads_nJ = options.inertia ? loads_.Evaluate(world_from_inner_, x_)
                                    : loads_.FitRigid(x_, &world_from_inner_);
  SetAnchors(*positions, velocities, options);
  if (Prepare()) loads_nJ = loads_.Evaluate(world_from_inner_, x_);
  elastic_nJ_ = Linearize(same);
  double anchors_nJ = AnchorEnergy();

  const int limit = options.max_newton_steps > 0 ? options.max_newton_steps : kMaxNewtonSteps;
  LinearSolve solve;
  for (;; ++report->steps) {
    std::swap(residual_, solved_residual_);
    double start = Residual(&report->gradient_norm);
    // Before the first step it is the targets that moved, and everything is off.
    const int most_patches = report->steps > 0 ? kMaxPatchSolves : 0;
    for (int patch = 0; patch < most_patches && CorrectPatch(); ++patch) {
      elastic_nJ_ = Linearize(true);
      loads_nJ = loads_.Evaluate(world_from_inner_, x_);
      anchors_nJ = AnchorEnergy();
      start = Residual(&report->gradient_norm);
    }
    const double energy = elastic_nJ_ + loads_nJ + anchors_nJ;
    double farthest = 0.0;
    const double anchor_curvature = Direct(0.0f, 0, &farthest);
    // ½ gᵀH⁻¹g, the energy still to gain, is at most ½ gᵀM⁻¹g over the lower end of the spectrum of
    // M⁻¹H.
    double gap = kGapSafety * 0.5 * start / lowest_ratio_;
    // Close to rest the energy is next to nothing. A further step is not worth it for less than
    // what matters beside springs drawn out by the tolerance of vertices.
    const double floor = options.tolerance * loads_.EnergyAt(kVertexToleranceMm);
    double allowed = options.tolerance * energy;
    if (report->steps > 0) {
      allowed += floor;
      if (gap > allowed) gap = GapAfter(solve, start);
    }
    // Likewise for the vertices, whose error M⁻¹r understates by about the root of that.
    const double error_mm = farthest / (kErrorSafety * std::sqrt(lowest_ratio_));
    report->converged = (gap <= allowed && error_mm <= kVertexToleranceMm) || farthest <= kStillMm;
    const int left = options.most_iterations > 0 ? options.most_iterations - report->cg_iterations
                                                 : kMaxCgIterations;
    if (report->converged || report->steps >= limit || left <= 0) break;
    // Where no vertex is off, it is the energy alone that has to come within its tolerance.
    const double part = error_mm < kFineError * kVertexToleranceMm
                            ? kEnergyPart * lowest_ratio_
                            : kLinearPart * std::sqrt(lowest_ratio_);
    const double enough = std::min(part * options.tolerance * energy, kLeastReduction * start);
    solve =
        SolveLinear(start, anchor_curvature,
                    {energy, enough, options.tolerance, floor, std::min(left, kMaxCgIterations)});
    report->cg_iterations += solve.iterations;
    // The quadratic model loses about ½ rᵀM⁻¹r; a step must keep a part of that.
    const double margin = 1e-5 * energy;  // rounding of the single-precision energy
    double length = 1.0;
    bool accepted = false;
    MoveBy(length);
    for (int halving = 0; halving <= kMaxHalvings; ++halving) {
      elastic_nJ_ = Linearize(false);
      loads_nJ = loads_.Evaluate(world_from_inner_, x_);
      anchors_nJ = AnchorEnergy();
      accepted = elastic_nJ_ + loads_nJ + anchors_nJ <= energy + margin - 1e-4 * length * start;
      if (accepted) break;
      MoveBy(-0.5 * length);
      length *= 0.5;
    }
    if (!accepted) {
      ++report->steps;
      break;
    }
  }
  report->elastic_energy_uJ = 1e-3 * elastic_nJ_;
  report->spring_energy_uJ = 1e-3 * loads_nJ;
  report->spring_weights = loads_.SpringWeights();
  Points moved(mesh_.VertexCount(), 3);
  for (Index v = 0; v < mesh_.VertexCount(); ++v)
    moved.row(v) =
        (world_from_inner_ * Eigen::Map<const Vec3>(&x_[3 * field_.Inner(v)])).transpose();
  if (options.inertia && velocities && options.time_step_s > 0.0)
    *velocities = (moved - *positions) / options.time_step_s;
  *positions = moved;
  last_positions_ = std::move(moved);
}

std::unique_ptr<ElasticSolver> MakeKerfSolver() { return std::make_unique<KerfSolver>(); }

}  // namespace kerf
