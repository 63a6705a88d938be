#include "Mechanics/ExactSolver.h"

#include "Core/Errors.h"
#include "Mechanics/ElasticSystem.h"

namespace kerf {
namespace {

/// Proximal term per step: keeps components without springs definite, vanishes at the minimizer.
constexpr double kProximal_1_s2 = 1.0;

class ExactSolver final : public ElasticSolver {
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
    if (positions->rows() != n) throw UsageError("positions and mesh differ in vertex count");
    workers_.Use(options.threads);
    VectorX x = Flatten(*positions), gradient;
    SolveReport report;
    double energy = Energy(springs, fixations, x, &gradient, &report);
    const int limit = options.max_newton_steps > 0 ? options.max_newton_steps : 100;
    for (; report.steps < limit; ++report.steps) {
      system_.AssembleElastic(workers_, x, ElasticSystem::Stiffness::Projected);
      VectorX unused = gradient;
      system_.AddFeatureForces(springs, fixations, x, &unused, true, nullptr);
      BlockMatrix& A = system_.Matrix();
      for (Index v = 0; v < n; ++v)
        A.Block(A.Slot(v, v)).diagonal().array() += kProximal_1_s2 * system_.Mass()[v];
      VectorX step = VectorX::Zero(3 * n);
      report.cg_iterations += SolveCg(workers_, A, -gradient, true, 1e-6, 0, &step).iterations;
      const double slope = gradient.dot(step);
      // Half the Newton decrement is the energy still to gain.
      report.converged =
          -0.5 * slope <= options.tolerance * energy || step.cwiseAbs().maxCoeff() < 1e-9;
      double length = 1.0;
      VectorX trial_gradient;
      bool better = false;
      for (int halving = 0; halving < 30 && !better; ++halving, length *= 0.5) {
        SolveReport trial_report = report;
        const VectorX trial = x + length * step;
        const double trial_energy =
            Energy(springs, fixations, trial, &trial_gradient, &trial_report);
        better = trial_energy <= energy + 1e-4 * length * slope;
        if (!better) continue;
        x = trial;
        energy = trial_energy;
        gradient = trial_gradient;
        report = trial_report;
      }
      if (report.converged || !better) break;
    }
    report.gradient_norm = gradient.cwiseAbs().maxCoeff();
    *positions = Unflatten(x);
    return report;
  }

 private:
  double Energy(const Springs& springs, const Fixations& fixations, const VectorX& x,
                VectorX* gradient, SolveReport* report) {
    system_.UpdateRotations(workers_, x);
    system_.ElasticGradient(workers_, x, gradient);
    const double elastic = system_.ElasticEnergy(workers_, x);
    const double feature =
        system_.AddFeatureForces(springs, fixations, x, gradient, false, &report->spring_weights);
    report->elastic_energy_uJ = 1e-3 * elastic;
    report->spring_energy_uJ = 1e-3 * feature;
    return elastic + feature;
  }

  ElasticSystem system_;
  Workers workers_;
};

}  // namespace

std::unique_ptr<ElasticSolver> MakeExactSolver() { return std::make_unique<ExactSolver>(); }

}  // namespace kerf
