/// The solvers on the moving-target workload: a kidney-sized ellipsoid, 225 surface features on one
/// half with springs of 10 N/m, targets turned by 15°, stretched by 10 % and moved by 5 mm over 30
/// frames. Every solver goes to the same tolerance, measured against a tightly converged solution
/// outside the clock.
#include <benchmark/benchmark.h>

#include <cmath>
#include <cstdlib>
#include <map>
#include <memory>

#include "Benchmarks/Percentiles.h"
#include "Logic/Mechanics/SpringScene.h"
#include "Mechanics/ExactSolver.h"

namespace kerf::testing {
namespace {

constexpr int kFrames = 30;
constexpr double kSpring_g_s2 = 1e4;
constexpr double kVertexToleranceMm = 0.05;
constexpr double kEnergyTolerance = 1e-3;

int Threads() {
  const char* threads = std::getenv("KERF_BENCHMARK_THREADS");
  return threads ? std::atoi(threads) : 0;
}

/// The mesh, its springs and the minimizer of each frame.
struct Workload {
  TetMesh mesh;
  Springs springs;
  std::vector<Points> minimizer;
  std::vector<double> energy_uJ;
};

const Workload& GetWorkload(int n) {
  static std::map<int, Workload> workloads;
  auto [found, is_new] = workloads.try_emplace(n);
  Workload& workload = found->second;
  if (!is_new) return workload;
  workload.mesh = Kidney(n);
  workload.springs = SurfaceSprings(workload.mesh, 225, kSpring_g_s2);
  auto fast = MakeKerfSolver();
  auto exact = MakeExactSolver();
  fast->Reset(workload.mesh, SoftTissue());
  exact->Reset(workload.mesh, SoftTissue());
  SolveOptions tight;
  tight.tolerance = 1e-7;
  Points positions = workload.mesh.rest;
  for (int frame = 1; frame <= kFrames; ++frame) {
    Springs springs = workload.springs;
    MoveTargets(workload.mesh, static_cast<double>(frame) / kFrames, &springs);
    fast->Solve(springs, {}, tight, &positions, nullptr);  // a good start, nothing more
    const SolveReport report = exact->Solve(springs, {}, tight, &positions, nullptr);
    workload.minimizer.push_back(positions);
    workload.energy_uJ.push_back(report.elastic_energy_uJ + report.spring_energy_uJ);
  }
  return workload;
}

void RunReference(benchmark::State& state, int n) {
  const Workload& workload = GetWorkload(n);
  std::vector<double> wall, cpu;
  double largest_error = 0.0, steps = 0.0;
  for (auto _ : state) {
    auto solver = MakeReferenceSolver();
    solver->Reset(workload.mesh, SoftTissue());
    SolveOptions options;
    options.threads = Threads();
    Points positions = workload.mesh.rest, velocities;
    Springs springs = workload.springs;
    double total = 0.0;
    for (int frame = 0; frame < kFrames; ++frame) {
      MoveTargets(workload.mesh, (frame + 1.0) / kFrames, &springs);
      double frame_wall = 0.0, frame_cpu = 0.0, error = 0.0, gap = 0.0;
      for (int step = 0; step < 200; ++step) {
        const Stopwatch clock;
        const SolveReport report = solver->Solve(springs, {}, options, &positions, &velocities);
        frame_wall += clock.Wall_ms();
        frame_cpu += clock.Cpu_ms();
        ++steps;
        error = LargestDistance(positions, workload.minimizer[frame]);
        const double energy = report.elastic_energy_uJ + report.spring_energy_uJ;
        gap = energy / workload.energy_uJ[frame] - 1.0;
        if (error <= kVertexToleranceMm && gap <= kEnergyTolerance) break;
      }
      largest_error = std::max(largest_error, error);
      wall.push_back(frame_wall);
      cpu.push_back(frame_cpu);
      total += frame_wall;
    }
    state.SetIterationTime(1e-3 * total);
  }
  ReportPercentiles(state, wall, cpu);
  state.counters["max_error_mm"] = largest_error;
  state.counters["steps"] = steps / static_cast<double>(wall.size());
}

void RunKerf(benchmark::State& state, int n) {
  const Workload& workload = GetWorkload(n);
  std::vector<double> wall, cpu;
  double largest_error = 0.0, largest_gap = 0.0, steps = 0.0, iterations = 0.0, converged = 0.0;
  for (auto _ : state) {
    auto solver = MakeKerfSolver();
    solver->Reset(workload.mesh, SoftTissue());
    SolveOptions options;
    options.threads = Threads();
    Points positions = workload.mesh.rest;
    Springs springs = workload.springs;
    // A first call at rest, as in a live session: the frames are what is measured.
    solver->Solve(springs, {}, options, &positions, nullptr);
    double total = 0.0;
    for (int frame = 0; frame < kFrames; ++frame) {
      MoveTargets(workload.mesh, (frame + 1.0) / kFrames, &springs);
      const Stopwatch clock;
      const SolveReport report = solver->Solve(springs, {}, options, &positions, nullptr);
      wall.push_back(clock.Wall_ms());
      cpu.push_back(clock.Cpu_ms());
      total += wall.back();
      steps += report.steps;
      iterations += report.cg_iterations;
      converged += report.converged;
      const double energy = report.elastic_energy_uJ + report.spring_energy_uJ;
      largest_gap = std::max(largest_gap, energy / workload.energy_uJ[frame] - 1.0);
      largest_error =
          std::max(largest_error, LargestDistance(positions, workload.minimizer[frame]));
    }
    state.SetIterationTime(1e-3 * total);
  }
  ReportPercentiles(state, wall, cpu);
  const double frames = static_cast<double>(wall.size());
  state.counters["max_error_mm"] = largest_error;
  state.counters["max_gap"] = largest_gap;
  state.counters["newton"] = steps / frames;
  state.counters["cg"] = iterations / frames;
  state.counters["converged"] = converged / frames;
}

const int kRegistered = [] {
  for (int n : {3, 6, 9, 13, 17}) {
    const std::string tets = std::to_string(20 * n * n * n);
    const int repeats = n < 10 ? 5 : 2;
    benchmark::RegisterBenchmark(("Solver/reference/" + tets).c_str(), RunReference, n)
        ->Iterations(1)
        ->UseManualTime()
        ->Unit(benchmark::kMillisecond);
    benchmark::RegisterBenchmark(("Solver/kerf/" + tets).c_str(), RunKerf, n)
        ->Iterations(repeats)
        ->UseManualTime()
        ->Unit(benchmark::kMillisecond);
  }
  return 0;
}();

}  // namespace
}  // namespace kerf::testing
