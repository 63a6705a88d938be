#include "Registration/GripFit.h"

#include <algorithm>
#include <cmath>

namespace kerf {
namespace {

/// Rows (2 per usable feature) of what lies between model features and lines of sight, mm at the
/// feature's rest depth.
struct Misfit {
  Eigen::VectorXd residual;  ///< 2M, across
  Eigen::VectorXd depth;     ///< M, along, from the rest position
  Eigen::VectorXd weight;    ///< M, of robust least squares
  double approach_mm = 0.0;  ///< mean depth from rest
  Eigen::VectorXd turn;      ///< 6G, rotation of each grip from rest, rad, at its parameters
  double turn_cost = 0.0;
  double cost = 0.0;  ///< of all
  double rms_mm = 0.0;
  double explained_share = 0.0;  ///< features within the robust scale
};

struct Sights {
  std::vector<Index> feature;
  std::vector<Eigen::Matrix<double, 2, 3>> across;  ///< unit rows orthogonal to the line of sight
  std::vector<Vec3> along;
  Embedding at;
  Points rest;
  Vec3 center;
};

Sights SightsOf(const BoundFeatures& bound, const Pixels& pixels, const std::vector<char>& usable,
                const CameraModel& camera) {
  Sights sights;
  sights.center = camera.Center();
  for (Index i = 0; i < static_cast<Index>(usable.size()); ++i)
    if (usable[i]) sights.feature.push_back(i);
  const Index m = static_cast<Index>(sights.feature.size());
  sights.at.tet.resize(m);
  sights.at.weights.resize(m, 4);
  sights.rest.resize(m, 3);
  for (Index k = 0; k < m; ++k) {
    const Index i = sights.feature[k];
    sights.at.tet[k] = bound.embedding.tet[i];
    sights.at.weights.row(k) = bound.embedding.weights.row(i);
    const Vec3 d = camera.RayThrough(pixels.row(i).transpose()).direction;
    const Vec3 u = d.unitOrthogonal();
    sights.along.push_back(d);
    sights.rest.row(k) = bound.rest.row(i);
    sights.across.emplace_back();
    sights.across.back().row(0) = u.transpose();
    sights.across.back().row(1) = d.cross(u).transpose();
  }
  return sights;
}

Misfit MisfitOf(const Sights& sights, const Points& positions,
                const std::vector<Eigen::Isometry3d>& motions, const TetMesh& mesh,
                const GripFitOptions& options, double approach) {
  const double scale_mm = options.robust_scale_mm;
  const Points p = sights.at.Positions(positions, mesh.tets);
  Misfit out;
  const Index m = static_cast<Index>(p.rows());
  out.residual.resize(2 * m);
  out.weight.resize(m);
  out.depth.resize(m);
  double sum = 0.0, weights = 0.0;
  for (Index k = 0; k < m; ++k) {
    const Eigen::Vector2d r = sights.across[k] * (Vec3(p.row(k).transpose()) - sights.center);
    out.residual.segment<2>(2 * k) = r;
    const double q = r.squaredNorm() / (scale_mm * scale_mm);
    out.depth[k] = sights.along[k].dot((p.row(k) - sights.rest.row(k)).transpose());
    out.cost +=
        scale_mm * scale_mm * q / (1.0 + q) + options.depth_weight * out.depth[k] * out.depth[k];
    out.explained_share += q < 1.0 ? 1.0 / double(m) : 0.0;
    out.weight[k] = 1.0 / ((1.0 + q) * (1.0 + q));
    sum += out.weight[k] * r.squaredNorm();
    weights += out.weight[k];
  }
  out.approach_mm = m > 0 ? out.depth.mean() : 0.0;
  out.cost += approach * out.approach_mm * out.approach_mm;
  out.turn = Eigen::VectorXd::Zero(6 * static_cast<Index>(motions.size()));
  for (std::size_t g = 0; g < motions.size(); ++g) {
    const Eigen::AngleAxisd turn(motions[g].linear());
    out.turn.segment<3>(6 * static_cast<Index>(g) + 3) = turn.angle() * turn.axis();
  }
  out.turn_cost = options.turn_weight_mm2 * double(m) * out.turn.squaredNorm();
  out.cost += out.turn_cost;
  out.rms_mm = weights > 0.0 ? std::sqrt(sum / weights) : 0.0;
  return out;
}

constexpr double kHold = 100.0;  // stiffness of a held vertex, E · mm
constexpr double kUsualApproach_mm = 10.0;
constexpr double kLawError = 0.15;    // of the squared strain: relative error of an organ's width
constexpr double kTolerance = 1e-4;   // relative energy gap
constexpr double kAtRest_mm2 = 1e-6;  // a cost per feature that no step needs to lower
constexpr int kNewtonStepsOfColumn = 4;
constexpr double kProbe_mm = 0.5;    // translation that a sensitivity is measured with
constexpr double kProbe_rad = 0.02;  // rotation

/// The organ in equilibrium with its held vertices at motions · rest, from `positions` on.
SolveReport Settle(const TetMesh& mesh, const Material& material,
                   const std::vector<GripRegion>& regions,
                   const std::vector<Eigen::Isometry3d>& motions, const GripFitOptions& fitting,
                   ElasticSolver* solver, Points* positions) {
  Fixations held;
  std::vector<Vec3> targets;
  for (std::size_t g = 0; g < regions.size(); ++g)
    for (Index v : VerticesIn(regions[g], mesh.rest)) {
      held.vertices.push_back(v);
      targets.push_back(motions[g] * Vec3(mesh.rest.row(v).transpose()));
    }
  held.targets.resize(targets.size(), 3);
  for (std::size_t k = 0; k < targets.size(); ++k) held.targets.row(k) = targets[k].transpose();
  held.stiffness_g_s2 = kHold * 1e3 * material.young_kPa;
  Springs none;
  none.at.tet.clear();
  none.at.weights.resize(0, 4);
  none.targets.resize(0, 3);
  none.stiffness.resize(0);
  none.directions.resize(0, 3);
  SolveOptions options;
  options.tolerance = kTolerance;
  options.max_newton_steps = fitting.newton_steps;
  options.most_iterations = fitting.most_iterations;
  Points velocities = Points::Zero(positions->rows(), 3);  // untouched without inertia
  return solver->Solve(none, held, options, positions, &velocities);
}

/// Mean squared strain: W_I = E V ε² / 2.
double SquaredStrain(double volume_mm3, const Material& material, double energy_uJ) {
  return 2e3 * energy_uJ / (1e3 * material.young_kPa * volume_mm3);
}

/// Weight of the square of the mean depth from rest. How far the whole organ has come nearer shows
/// only in its size, and so does what the law gets wrong about its width when it is stretched:
/// about half the squared strain. What size says of depth is worth less by that.
double ApproachWeight(const Sights& sights, double strain2, const CameraModel& camera) {
  const Vec3 axis = camera.ViewDirection();
  double information = 0.0, distance_mm = 0.0;
  for (std::size_t k = 0; k < sights.across.size(); ++k) {
    information += (sights.across[k] * axis).squaredNorm();
    distance_mm += (Vec3(sights.rest.row(k).transpose()) - sights.center).norm();
  }
  distance_mm /= double(sights.across.size());
  const double sigma_mm = kLawError * strain2 * distance_mm;
  return information * (sigma_mm * sigma_mm) / (kUsualApproach_mm * kUsualApproach_mm);
}

/// `motion` after the parameter change `step`, about `center` as it is now.
Eigen::Isometry3d Moved(const Eigen::Isometry3d& motion, const Vec3& center,
                        const Eigen::Matrix<double, 6, 1>& step) {
  const double angle = step.tail<3>().norm();
  Eigen::Isometry3d change = Eigen::Isometry3d::Identity();
  if (angle > 0.0)
    change.linear() = Eigen::AngleAxisd(angle, step.tail<3>() / angle).toRotationMatrix();
  change.translation() = center + step.head<3>() - change.linear() * center;
  return change * motion;
}

std::vector<Vec3> CentersOf(const GripFit& fit, const Points& rest) {
  std::vector<Vec3> centers;
  for (std::size_t g = 0; g < fit.regions.size(); ++g) {
    Vec3 sum = Vec3::Zero();
    const auto vertices = VerticesIn(fit.regions[g], rest);
    for (Index v : vertices) sum += rest.row(v).transpose();
    centers.push_back(fit.motions[g] * Vec3(sum / double(vertices.size())));
  }
  return centers;
}

void RenewColumn(const TetMesh& mesh, const Material& material, const GripFitOptions& options,
                 const Embedding& features, ElasticSolver* solver, GripFit* fit) {
  const int column = fit->next_column;
  fit->next_column = (column + 1) % static_cast<int>(fit->sensitivities.cols());
  const int g = column / 6, k = column % 6;
  const double by = k < 3 ? kProbe_mm : kProbe_rad;
  std::vector<Eigen::Isometry3d> motions = fit->motions;
  motions[g] =
      Moved(motions[g], CentersOf(*fit, mesh.rest)[g], by * Eigen::Matrix<double, 6, 1>::Unit(k));
  Points positions = fit->positions;
  fit->fields.resize(fit->sensitivities.cols());
  if (fit->fields[column]) positions += by * *fit->fields[column];
  // A newer one starts where the older one leads, and is nearer to the equilibrium in any case.
  GripFitOptions most = options;
  if (!fit->fields[column]) {
    most.newton_steps = std::max(kNewtonStepsOfColumn, options.newton_steps);
    most.most_iterations = 0;
  }
  Settle(mesh, material, fit->regions, motions, most, solver, &positions);
  auto field = std::make_shared<Points>((positions - fit->positions) / by);
  const Points change = features.Positions(*field, mesh.tets);
  fit->sensitivities.col(column) = Eigen::Map<const Eigen::VectorXd>(change.data(), change.size());
  fit->fields[column] = std::move(field);
}

/// Whether the sensitivities of the whole organ are known.
bool HasFields(const GripFit& fit) {
  return static_cast<Index>(fit.fields.size()) == fit.sensitivities.cols() &&
         std::all_of(fit.fields.begin(), fit.fields.end(), [](const auto& field) { return field; });
}

/// Where the organ will come to lie, to first order, when the grips take the step `q`; unchanged
/// where the sensitivities of the whole organ are not known.
Points Foreseen(const GripFit& fit, const Eigen::VectorXd& q) {
  Points positions = fit.positions;
  const bool known = HasFields(fit);
  for (Index column = 0; known && column < q.size(); ++column)
    positions += q[column] * *fit.fields[column];
  return positions;
}

}  // namespace

void FollowCut(const TopologyChange& change, GripFit* fit) {
  fit->positions = change.MapVertexField(fit->positions);
  for (auto& field : fit->fields)
    if (field) field = std::make_shared<Points>(change.MapVertexField(*field));
  fit->settled = false;
  fit->torn = true;
}

std::vector<Index> VerticesIn(const GripRegion& region, const Points& rest) {
  std::vector<Index> vertices;
  for (Index v = 0; v < static_cast<Index>(rest.rows()); ++v)
    if (region.Holds(rest.row(v).transpose())) vertices.push_back(v);
  return vertices;
}

Points BentByGrips(const GripFit& fit, const Points& rest) {
  // The two regions look along the same axis, either way.
  const Vec3 axis = fit.regions[0].axis;
  const double far = fit.regions[0].from_mm, near = -fit.regions[1].from_mm;
  Points bent(rest.rows(), 3);
  for (Index v = 0; v < static_cast<Index>(rest.rows()); ++v) {
    const Vec3 x = rest.row(v).transpose();
    const double t = std::clamp((axis.dot(x) - near) / (far - near), 0.0, 1.0);
    bent.row(v) = (t * (fit.motions[0] * x) + (1.0 - t) * (fit.motions[1] * x)).transpose();
  }
  return bent;
}

GripFit Regripped(const GripFit& fit, const std::vector<double>& factors) {
  GripFit other = fit;
  for (std::size_t g = 0; g < other.regions.size(); ++g) {
    GripRegion& region = other.regions[g];
    region.from_mm = region.end_mm - factors[g] * (region.end_mm - region.from_mm);
  }
  other.settled = false;
  other.fields.clear();
  return other;
}

GripFit MovedOn(GripFit fit, const GripFit& then, const GripFit& now, const Points& rest) {
  const std::vector<Vec3> centers = CentersOf(fit, rest);
  const Points bent_before = BentByGrips(fit, rest);
  Eigen::VectorXd q(6 * static_cast<Index>(fit.motions.size()));
  for (std::size_t g = 0; g < fit.motions.size(); ++g) {
    const Eigen::Isometry3d change = now.motions[g] * then.motions[g].inverse();
    const Eigen::AngleAxisd turn(change.linear());
    q.segment<3>(6 * static_cast<Index>(g)) = change * centers[g] - centers[g];
    q.segment<3>(6 * static_cast<Index>(g) + 3) = turn.angle() * turn.axis();
    fit.motions[g] = change * fit.motions[g];
  }
  if (HasFields(fit))
    fit.positions = Foreseen(fit, q);
  else
    fit.positions += BentByGrips(fit, rest) - bent_before;
  fit.trust = now.trust;
  fit.trust_across = now.trust_across;
  fit.settled = false;
  fit.torn = true;
  return fit;
}

GripFit BeginGrips(const TetMesh& mesh, const BoundFeatures& bound, const Material& material,
                   const GripFitOptions& options, ElasticSolver* solver) {
  GripFit fit;
  const Eigen::RowVector3d mean = mesh.rest.colwise().mean();
  const Points centered = mesh.rest.rowwise() - mean;
  const Eigen::SelfAdjointEigenSolver<Mat3> axes(centered.transpose() * centered);
  const Vec3 along = axes.eigenvectors().col(2);
  const Eigen::VectorXd s = mesh.rest * along;
  const double length = s.maxCoeff() - s.minCoeff();
  fit.regions = {{along, s.maxCoeff() - options.cap_share * length, s.maxCoeff()},
                 {-along, -s.minCoeff() - options.cap_share * length, -s.minCoeff()}};
  fit.motions.assign(2, Eigen::Isometry3d::Identity());
  fit.positions = mesh.rest;
  for (Index t = 0; t < mesh.TetCount(); ++t) fit.volume_mm3 += TetVolume(mesh.rest, mesh.tets, t);
  solver->Reset(mesh, material);
  fit.sensitivities.resize(3 * bound.rest.rows(), 12);
  for (int column = 0; column < 12; ++column)
    RenewColumn(mesh, material, options, bound.embedding, solver, &fit);
  return fit;
}

void UpdateGrips(const TetMesh& mesh, const Material& material, const BoundFeatures& bound,
                 const Pixels& pixels, const std::vector<char>& usable, const CameraModel& camera,
                 const GripFitOptions& options, ElasticSolver* solver, GripFit* fit) {
  const Sights sights = SightsOf(bound, pixels, usable, camera);
  const Index m = static_cast<Index>(sights.feature.size());
  if (m < 12) {
    fit->trust = std::max(0.0, fit->trust - options.trust_lost);
    fit->trust_across = std::max(0.0, fit->trust_across - options.trust_lost);
    fit->residual_mm = 0.0;  // nothing to explain, nothing to probe
    return;
  }
  const auto settled = [&](const SolveReport& report) {
    fit->settled = report.converged;
    fit->strain2 = SquaredStrain(fit->volume_mm3, material, report.elastic_energy_uJ);
  };
  int spent = 0;  // iterations of this frame
  if (!fit->settled) {
    const SolveReport report =
        Settle(mesh, material, fit->regions, fit->motions, options, solver, &fit->positions);
    settled(report);
    spent = report.cg_iterations;
  }
  fit->waited = SettlesOnly(*fit);
  fit->torn = false;
  if (fit->waited) return;  // what lies between is no measure yet
  const auto given_up = [&] { return options.given_up && *options.given_up; };
  const bool due = --fit->frames_to_renewal < 0 || !HasFields(*fit);
  const bool has_time = options.most_iterations == 0 || 2 * spent <= options.most_iterations ||
                        fit->frames_to_renewal < -options.renewal_frames || !HasFields(*fit);
  if (due && has_time && fit->settled && options.renewed_columns > 0) {
    for (int i = 0; i < options.renewed_columns && !given_up(); ++i)  // from the equilibrium
      RenewColumn(mesh, material, options, bound.embedding, solver, fit);
    fit->frames_to_renewal = options.renewal_frames - 1;
  }
  const double approach = ApproachWeight(sights, fit->strain2, camera);
  Misfit now = MisfitOf(sights, fit->positions, fit->motions, mesh, options, approach);
  const Index n = fit->sensitivities.cols();
  GripFitOptions trial = options;  // has what settling has left of the work, or half of it
  if (options.most_iterations > 0)
    trial.most_iterations =
        std::max(options.most_iterations - spent, (options.most_iterations + 1) / 2);
  for (int step = 0; step < options.steps && !given_up(); ++step) {
    Eigen::MatrixXd across(2 * m, n), along(m, n);  // of the features by the parameters
    for (Index k = 0; k < m; ++k) {
      const auto moved = fit->sensitivities.middleRows<3>(3 * sights.feature[k]);
      across.middleRows<2>(2 * k).noalias() = sights.across[k].lazyProduct(moved);
      along.row(k).noalias() = sights.along[k].transpose().lazyProduct(moved);
    }
    Eigen::VectorXd weight(2 * m);
    for (Index k = 0; k < m; ++k) weight.segment<2>(2 * k).setConstant(now.weight[k]);
    const Eigen::MatrixXd weighted = weight.asDiagonal() * across;
    const Eigen::VectorXd mean_along = along.colwise().mean().transpose();
    Eigen::MatrixXd A = across.transpose() * weighted;
    A += options.depth_weight * (along.transpose() * along);
    A += approach * mean_along * mean_along.transpose();
    const Eigen::VectorXd b = -(weighted.transpose() * now.residual) -
                              options.depth_weight * (along.transpose() * now.depth) -
                              approach * now.approach_mm * mean_along -
                              options.turn_weight_mm2 * double(m) * now.turn;
    for (Index i = 0; i < n; ++i)
      if (i % 6 >= 3) A(i, i) += options.turn_weight_mm2 * double(m);
    A.diagonal() += fit->lambda * A.diagonal();
    const Eigen::VectorXd q = A.ldlt().solve(b);
    if (!q.allFinite()) break;
    const std::vector<Vec3> centers = CentersOf(*fit, mesh.rest);
    std::vector<Eigen::Isometry3d> motions = fit->motions;
    for (std::size_t g = 0; g < motions.size(); ++g)
      motions[g] = Moved(motions[g], centers[g], q.segment<6>(6 * g));
    Points positions = Foreseen(*fit, q);
    const SolveReport report =
        Settle(mesh, material, fit->regions, motions, trial, solver, &positions);
    const Misfit then = MisfitOf(sights, positions, motions, mesh, options, approach);
    if (then.cost < now.cost) {
      fit->motions = motions;
      fit->positions = positions;
      now = then;
      settled(report);
      fit->lambda = std::max(1e-4, 0.3 * fit->lambda);
    } else if (now.cost > kAtRest_mm2 * double(m)) {
      fit->lambda = std::min(1e3, 10.0 * fit->lambda);
    }
  }
  fit->cost_mm2 = (now.cost - now.turn_cost) / double(m);
  fit->residual_mm = now.rms_mm;
  const auto falling = [](double value, double full, double none) {
    return std::clamp((none - value) / (none - full), 0.0, 1.0);
  };
  const double deserved =
      falling(now.rms_mm, options.believed_mm, options.disbelieved_mm) *
      falling(fit->strain2, options.linear_strain2, options.nonlinear_strain2) *
      falling(-now.explained_share, -options.explained_share, -options.unexplained_share);
  const auto follow = [&](double value, double* trust) {
    *trust += std::clamp(value - *trust, -options.trust_lost, options.trust_gained);
  };
  follow(deserved, &fit->trust);
  // Only where it is the law that is not believed.
  follow(falling(now.rms_mm, options.believed_across_mm, options.disbelieved_across_mm) *
             falling(-fit->strain2, -options.nonlinear_strain2, -options.linear_strain2),
         &fit->trust_across);
}

}  // namespace kerf
