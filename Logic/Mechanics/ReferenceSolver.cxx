#include "Core/Errors.h"
#include "Mechanics/ElasticSystem.h"

namespace kerf {
namespace {

/// Rayleigh damping D = α M + β K. Stiffness damping sets how far the model lags behind its targets
/// (0.1 s takes about eight steps of 0.04 s to settle, 0.005 s two), so it is small; mass damping
/// takes away rigid drift.
constexpr double kMassDamping_1_s = 0.1;
constexpr double kStiffnessDamping_s = 0.002;
/// A call has converged when its last step moved no vertex farther than this.
constexpr double kStillMm = 0.01;

/// Implicit Euler, linearized once a step (warped stiffness K), for the velocity at the end of the
/// step:
///   (M + h D + h² K) Δv = h (f − D v − h K v),  x ← x + h (v + Δv),  f = −∂(W_I + W_S)/∂P_V.
class ReferenceSolver final : public ElasticSolver {
 public:
  void Reset(const TetMesh& mesh, const Material& material) override {
    system_.Reset(mesh, material);
  }

  void Apply(const TopologyChange& change) override { system_.Apply(change); }

  SolveReport Solve(const Springs& springs, const Fixations& fixations, const SolveOptions& options,
                    Points* positions, Points* velocities) override {
    const Index n = system_.Mesh().VertexCount();
    ValidateSprings(springs, system_.Mesh().TetCount());
    ValidateFixations(fixations, n);
    const double h = options.time_step_s;
    if (!(h > 0.0)) throw UsageError("the time step must be positive (s)");
    if (positions->rows() != n) throw UsageError("positions and mesh differ in vertex count");
    workers_.Use(options.threads);
    VectorX x = Flatten(*positions);
    VectorX v = velocities && velocities->rows() == n ? Flatten(*velocities) : VectorX::Zero(3 * n);
    SolveReport report;
    const int steps = std::max(1, options.steps);
    double moved = 0.0;
    for (; report.steps < steps; ++report.steps) {
      const VectorX before = x;
      report.cg_iterations += Step(springs, fixations, options, h, &x, &v);
      moved = (x - before).cwiseAbs().maxCoeff();
    }
    report.converged = moved <= kStillMm;
    VectorX gradient;
    system_.UpdateRotations(workers_, x);
    system_.ElasticGradient(workers_, x, &gradient);
    report.spring_energy_uJ = 1e-3 * system_.AddFeatureForces(springs, fixations, x, &gradient,
                                                              false, &report.spring_weights);
    report.elastic_energy_uJ = 1e-3 * system_.ElasticEnergy(workers_, x);
    report.gradient_norm = gradient.cwiseAbs().maxCoeff();
    *positions = Unflatten(x);
    if (velocities) *velocities = Unflatten(v);
    return report;
  }

 private:
  int Step(const Springs& springs, const Fixations& fixations, const SolveOptions& options,
           double h, VectorX* x, VectorX* v) {
    VectorX gradient, stiffness_v;
    system_.UpdateRotations(workers_, *x);
    system_.ElasticGradient(workers_, *x, &gradient);
    system_.AssembleElastic(workers_, *x, ElasticSystem::Stiffness::Warped);
    system_.AddFeatureForces(springs, fixations, *x, &gradient, true, nullptr);
    BlockMatrix& A = system_.Matrix();
    A.Multiply(workers_, *v, &stiffness_v);
    const VectorX& mass = system_.Mass();
    VectorX b = -h * gradient - h * (h + kStiffnessDamping_s) * stiffness_v;
    const double stiffness_factor = h * h + h * kStiffnessDamping_s;
    for (Index s = 0; s < A.SlotCount(); ++s) A.Block(s) *= stiffness_factor;
    for (Index i = 0; i < A.Rows(); ++i) {
      b.segment<3>(3 * i) -= h * kMassDamping_1_s * mass[i] * v->segment<3>(3 * i);
      A.Block(A.Slot(i, i)).diagonal().array() += (1.0 + h * kMassDamping_1_s) * mass[i];
    }
    VectorX dv = VectorX::Zero(b.size());
    const CgReport cg =
        SolveCg(workers_, A, b, false, options.tolerance, options.max_cg_iterations, &dv);
    *v += dv;
    *x += h * *v;
    return cg.iterations;
  }

  ElasticSystem system_;
  Workers workers_;
};

}  // namespace

std::unique_ptr<ElasticSolver> MakeReferenceSolver() { return std::make_unique<ReferenceSolver>(); }

}  // namespace kerf
