#include <cmath>
#include <numeric>

#include "Core/Errors.h"
#include "Mechanics/TwoLevelPreconditioner.h"

namespace kerf {
namespace {

using simd::F4;

constexpr Index kVertexChunk = 1024;
constexpr int kMaxNewtonSteps = 12;
constexpr int kMaxCgIterations = 80;
constexpr int kMaxHalvings = 10;
/// Relative reduction of the energy norm of the residual per linear solve.
constexpr double kCgReduction = 0.01;
constexpr double kVertexToleranceMm = 0.05;
/// The iteration sees the lower end of the spectrum from above.
constexpr double kGapSafety = 1.5, kErrorSafety = 1.0;
/// Motion below which nothing is worth solving, whatever the relative energy gap.
constexpr double kStillMm = 0.0003;
/// Total stiffness of the proximal anchors of a component, relative to its springs
/// or, if that is less, to E·V^(1/3): they hold what
/// no spring holds (the depth along pure rays, turns about a line) and shift the rest by a
/// thousandth of its motion in a call.
constexpr double kAnchorFraction = 1e-3;
/// A component without any spring is held by the inertia of a time step of this length.
constexpr double kFreeTimeStep_s = 0.04;

Eigen::Map<Vec3> At(std::vector<double>* positions, Index v) {
  return Eigen::Map<Vec3>(positions->data() + 3 * v);
}

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
    double farthest_mm = 0.0;  ///< largest vertex motion of M⁻¹r at its start
  };

  Index VertexChunks() const { return (field_.VertexCount() + kVertexChunk - 1) / kVertexChunk; }
  void SetRest();
  void Synchronize(const Points& positions);
  void SetAnchors(const Points& positions, const Points* velocities, const SolveOptions& options);
  double Linearize(bool only_stale);
  double AnchorEnergy() const;
  /// residual_ = −gradient of everything, preconditioned. @return rᵀM⁻¹r
  double Residual(double* largest_uN);
  /// smooth_ = D⁻¹ residual_ and Pᵀ residual_ of a vertex chunk. @return its rᵀD⁻¹r
  double SmoothChunk(Index begin, Index end);
  /// coarse_ = (PᵀKP)⁻¹ Pᵀ residual_ when all chunks are smoothed. @return its part of rᵀM⁻¹r
  double CorrectCoarse();
  /// direction_ = M⁻¹ residual_ + beta direction_. @return Σ anchor |p|²; farthest motion of M⁻¹r
  double Direct(float beta, double* farthest_mm);
  /// Conjugate gradient for step_, from the residual; the first preconditioning and direction are
  /// done. @param most iterations
  LinearSolve SolveLinear(double start_nJ, double enough_nJ, double anchor_curvature, int most);
  void MoveBy(double length);

  TetMesh mesh_;
  Material material_;
  Workers workers_;
  ElementField field_;
  FeatureLoads loads_;
  TwoLevelPreconditioner preconditioner_;
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
  std::vector<F4> x32_, residual_, smooth_, direction_, step_;
  std::vector<std::vector<F4>> coarse_parts_;
  std::vector<F4> coarse_residual_, coarse_;
  Points last_positions_;  ///< what the last call returned
  double elastic_nJ_ = 0.0;
  double lowest_ratio_ =
      0.3;  ///< lower end of the spectrum of M⁻¹H as the last linear solve saw it
  bool renumbered_ = true;
};

void KerfSolver::Reset(const TetMesh& mesh, const Material& material) {
  material.Validate();
  mesh_ = mesh;
  material_ = material;
  field_.Reset(mesh, material);
  center_ = Vec3::Zero();
  if (mesh.VertexCount() > 0) center_ = mesh.rest.colwise().mean().transpose();
  SetRest();
  preconditioner_.Reset(workers_, rest_, field_);
  x_.clear();
  last_positions_.resize(0, 3);
  lowest_ratio_ = 0.3;
  renumbered_ = true;
}

void KerfSolver::SetRest() {
  rest_.assign(field_.VertexCount(), Vec3::Zero());
  for (Index v = 0; v < mesh_.VertexCount(); ++v)
    rest_[field_.Inner(v)] = mesh_.rest.row(v).transpose() - center_;
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
  Points inner = Points::Zero(mesh_.VertexCount(), 3);
  if (!x_.empty())
    for (Index v = 0; v < mesh_.VertexCount(); ++v)
      inner.row(v) = Eigen::Map<const Vec3>(&x_[3 * field_.Inner(v)]).transpose();
  inner = change.MapVertexField(inner);
  // The caller maps its positions in the same way, so the next call recognizes the pose.
  if (last_positions_.rows() > 0) last_positions_ = change.MapVertexField(last_positions_);
  const ElementField::Patch patch = field_.Apply(workers_, change.mesh, material_, change);
  mesh_ = change.mesh;
  SetRest();
  if (!x_.empty()) {
    x_.assign(3 * static_cast<std::size_t>(field_.VertexCount()), 0.0);
    for (Index v = 0; v < mesh_.VertexCount(); ++v)
      At(&x_, field_.Inner(v)) = inner.row(v).transpose();
  }
  preconditioner_.Apply(workers_, rest_, field_, patch);
  renumbered_ = true;
}

void KerfSolver::Synchronize(const Points& positions) {
  const Index n = field_.VertexCount();
  x32_.resize(n);
  residual_.resize(n);
  smooth_.resize(n);
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
  }
  elastic_nJ_ = Linearize(same);
}

double KerfSolver::Linearize(bool only_stale) {
  workers_.ForChunks(field_.VertexCount(), kVertexChunk, [&](Index begin, Index end) {
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
  return workers_.SumChunks(field_.VertexCount(), kVertexChunk, [&](Index begin, Index end) {
    double sum = 0.0;
    for (Index v = begin; v < end; ++v)
      for (int i = 0; i < 3; ++i) {
        const double d = x_[3 * v + i] - anchor_at_[3 * v + i];
        sum += 0.5 * static_cast<double>(anchor_[v]) * d * d;
      }
    return sum;
  });
}

double KerfSolver::Residual(double* largest_uN) {
  std::vector<float> largest(VertexChunks(), 0.0f);
  coarse_parts_.resize(VertexChunks());
  const auto chunk = [&](Index begin, Index end) {
    for (Index v = begin; v < end; ++v) {
      const __m128 minus = _mm_set1_ps(-0.0f);
      const F4 anchor{anchor_[v] * static_cast<float>(x_[3 * v] - anchor_at_[3 * v]),
                      anchor_[v] * static_cast<float>(x_[3 * v + 1] - anchor_at_[3 * v + 1]),
                      anchor_[v] * static_cast<float>(x_[3 * v + 2] - anchor_at_[3 * v + 2]), 0.0f};
      simd::Store(&residual_[v],
                  _mm_xor_ps(minus, _mm_add_ps(field_.GradientAt(v), simd::Load(anchor))));
    }
    loads_.ForVertices(begin, end, [&](Index v, Index l, float w) {
      simd::Store(&residual_[v],
                  _mm_sub_ps(simd::Load(residual_[v]),
                             _mm_mul_ps(_mm_set1_ps(w), simd::Load(loads_.Loads()[l].gradient))));
    });
    float most = 0.0f;
    for (Index v = begin; v < end; ++v)
      most = std::max(
          {most, std::abs(residual_[v].x), std::abs(residual_[v].y), std::abs(residual_[v].z)});
    largest[begin / kVertexChunk] = most;
    return SmoothChunk(begin, end);
  };
  const double product = workers_.SumChunks(field_.VertexCount(), kVertexChunk, chunk);
  *largest_uN = static_cast<double>(*std::max_element(largest.begin(), largest.end()));
  return product + CorrectCoarse();
}

double KerfSolver::SmoothChunk(Index begin, Index end) {
  std::vector<F4>& sums = coarse_parts_[begin / kVertexChunk];
  sums.assign(preconditioner_.FunctionCount(), F4{});
  double sum = 0.0;
  for (Index v = begin; v < end; ++v) {
    const __m128 r = simd::Load(residual_[v]), z = preconditioner_.Smooth(v, r);
    simd::Store(&smooth_[v], z);
    sum += static_cast<double>(simd::Dot3(r, z));
    preconditioner_.Restrict(v, r, sums.data());
  }
  return sum;
}

double KerfSolver::CorrectCoarse() {
  const Index functions = preconditioner_.FunctionCount();
  coarse_residual_.assign(functions, F4{});
  for (const std::vector<F4>& part : coarse_parts_)
    for (Index f = 0; f < functions; ++f)
      simd::Store(&coarse_residual_[f],
                  _mm_add_ps(simd::Load(coarse_residual_[f]), simd::Load(part[f])));
  coarse_ = coarse_residual_;
  preconditioner_.SolveCoarse(coarse_.data());
  double product = 0.0;
  for (Index f = 0; f < functions; ++f)
    product +=
        static_cast<double>(simd::Dot3(simd::Load(coarse_residual_[f]), simd::Load(coarse_[f])));
  return product;
}

double KerfSolver::Direct(float beta, double* farthest_mm) {
  std::vector<float> farthest(VertexChunks(), 0.0f);
  const __m128 b = _mm_set1_ps(beta);
  const double curvature =
      workers_.SumChunks(field_.VertexCount(), kVertexChunk, [&](Index begin, Index end) {
        double sum = 0.0;
        float most = 0.0f;
        for (Index v = begin; v < end; ++v) {
          const __m128 z =
              _mm_add_ps(simd::Load(smooth_[v]), preconditioner_.Prolong(v, coarse_.data()));
          const __m128 p =
              beta == 0.0f ? z : _mm_add_ps(z, _mm_mul_ps(b, simd::Load(direction_[v])));
          simd::Store(&direction_[v], p);
          sum += static_cast<double>(anchor_[v] * simd::Dot3(p, p));
          most = std::max(most, simd::Dot3(z, z));
        }
        farthest[begin / kVertexChunk] = most;
        return sum;
      });
  const float most = farthest.empty() ? 0.0f : *std::max_element(farthest.begin(), farthest.end());
  *farthest_mm = std::sqrt(static_cast<double>(most));
  return curvature;
}

KerfSolver::LinearSolve KerfSolver::SolveLinear(double start_nJ, double enough_nJ,
                                                double anchor_curvature, int most) {
  LinearSolve solve;
  solve.start_nJ = solve.end_nJ = start_nJ;
  std::fill(step_.begin(), step_.end(), F4{});
  const Index chunks = static_cast<Index>(field_.Chunks().size());
  // Where the energy is good enough already, it is the vertices that are not.
  const double target =
      std::max(kCgReduction * kCgReduction * start_nJ, std::min(enough_nJ, 0.05 * start_nJ));
  std::vector<double> alphas, betas;
  double rz = start_nJ, farthest = 0.0;
  while (solve.iterations < most && rz > target) {
    // Chunk `chunks` stands for the springs.
    const double curvature =
        anchor_curvature + workers_.SumChunks(chunks + 1, 1, [&](Index c, Index) {
          return c < chunks ? field_.MultiplyChunk(c, direction_.data())
                            : loads_.Multiply(direction_.data());
        });
    if (!(curvature > 0.0)) break;
    const double alpha = rz / curvature;
    const __m128 a = _mm_set1_ps(static_cast<float>(alpha));
    const auto update = [&](Index begin, Index end) {
      for (Index v = begin; v < end; ++v) {
        const __m128 p = simd::Load(direction_[v]);
        const __m128 q = _mm_add_ps(field_.ProductAt(v), _mm_mul_ps(_mm_set1_ps(anchor_[v]), p));
        simd::Store(&residual_[v], _mm_sub_ps(simd::Load(residual_[v]), _mm_mul_ps(a, q)));
        simd::Store(&step_[v], _mm_add_ps(simd::Load(step_[v]), _mm_mul_ps(a, p)));
      }
      loads_.ForVertices(begin, end, [&](Index v, Index l, float w) {
        simd::Store(&residual_[v], _mm_sub_ps(simd::Load(residual_[v]),
                                              _mm_mul_ps(_mm_mul_ps(a, _mm_set1_ps(w)),
                                                         simd::Load(loads_.Products()[l]))));
      });
      return SmoothChunk(begin, end);
    };
    const double smoothed = workers_.SumChunks(field_.VertexCount(), kVertexChunk, update);
    const double next = smoothed + CorrectCoarse();
    const double beta = next / rz;
    alphas.push_back(alpha);
    betas.push_back(beta);
    rz = next;
    ++solve.iterations;
    if (!(rz > target)) break;
    anchor_curvature = Direct(static_cast<float>(beta), &farthest);
  }
  solve.end_nJ = rz;
  // The tridiagonal matrix of the iteration has the ends of the spectrum of M⁻¹H as its own.
  const Index m = static_cast<Index>(alphas.size());
  if (m >= 3) {
    Eigen::VectorXd diagonal(m), off(m - 1);
    for (Index k = 0; k < m; ++k) {
      diagonal[k] = 1.0 / alphas[k] + (k > 0 ? betas[k - 1] / alphas[k - 1] : 0.0);
      if (k + 1 < m) off[k] = std::sqrt(betas[k]) / alphas[k];
    }
    Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen;
    eigen.computeFromTridiagonal(diagonal, off, Eigen::EigenvaluesOnly);
    lowest_ratio_ = std::clamp(eigen.eigenvalues()[0], 0.02, 1.0);
  }
  return solve;
}

void KerfSolver::MoveBy(double length) {
  workers_.ForChunks(field_.VertexCount(), kVertexChunk, [&](Index begin, Index end) {
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
  Synchronize(*positions);
  loads_.Set(springs, fixations, mesh_, field_, renumbered_);
  renumbered_ = false;
  // With inertia the rigid motion has its own dynamics; without, its minimum is found beforehand.
  double loads_nJ = options.inertia ? loads_.Evaluate(world_from_inner_, x_)
                                    : loads_.FitRigid(x_, &world_from_inner_);
  SetAnchors(*positions, velocities, options);
  preconditioner_.Update(workers_, field_, loads_, anchor_);
  double anchors_nJ = options.inertia ? AnchorEnergy() : 0.0;

  const int limit = options.max_newton_steps > 0 ? options.max_newton_steps : kMaxNewtonSteps;
  for (;; ++report->steps) {
    const double start = Residual(&report->gradient_norm);
    const double energy = elastic_nJ_ + loads_nJ + anchors_nJ;
    double farthest = 0.0;
    const double anchor_curvature = Direct(0.0f, &farthest);
    // ½ gᵀH⁻¹g, the energy still to gain, is at most ½ gᵀM⁻¹g over the lower end of the spectrum of
    // M⁻¹H.
    const double gap = kGapSafety * 0.5 * start / lowest_ratio_;
    // Likewise for the vertices, whose error M⁻¹r understates by about the root of that.
    const double error_mm = farthest / (kErrorSafety * std::sqrt(lowest_ratio_));
    report->converged = (gap <= options.tolerance * energy && error_mm <= kVertexToleranceMm) ||
                        farthest <= kStillMm;
    const int left = options.most_iterations > 0 ? options.most_iterations - report->cg_iterations
                                                 : kMaxCgIterations;
    if (report->converged || report->steps >= limit || left <= 0) break;
    const double enough = 0.1 * lowest_ratio_ * options.tolerance * energy;
    const LinearSolve solve =
        SolveLinear(start, enough, anchor_curvature, std::min(left, kMaxCgIterations));
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

}  // namespace

std::unique_ptr<ElasticSolver> MakeKerfSolver() { return std::make_unique<KerfSolver>(); }

}  // namespace kerf
