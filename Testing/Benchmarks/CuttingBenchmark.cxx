/// A cut through 40 mm of tissue that grows by 10 mm an increment, in an ellipsoid of 120 × 80 × 40
/// mm. Times are of the increments in the middle of the cut, where each opens about 4 cm².
#include <benchmark/benchmark.h>

#include "Benchmarks/Percentiles.h"
#include "Cutting/ExtrudePolyline.h"
#include "Cutting/TetCutter.h"
#include "Support/TestMeshes.h"

namespace kerf::testing {
namespace {

CutSurface CutUpTo(int columns) {
  Points line(columns, 3), down(1, 3);
  for (int i = 0; i < columns; ++i) line.row(i) << 1.7 + 0.3 * i, -45.0 + 10.0 * i, 30;
  down << 0.05, 0, -1;
  return ExtrudePolyline(line, down, 5, 70, 2.5);
}

void CuttingIncrement(benchmark::State& state, int n) {
  const TetMesh uncut = EllipsoidMesh({60, 40, 20}, n);
  std::vector<double> wall_ms, cpu_ms;
  Index new_tets = 0;
  double area_mm2 = 0, angle_deg = 180;
  for (auto _ : state) {
    TetMesh mesh = uncut;
    Points positions = uncut.rest;
    TetCutter cutter;
    double seconds = 0;
    for (int columns = 2; columns < 8; ++columns) {
      const CutSurface surface = CutUpTo(columns);
      CutReport report;
      const Stopwatch watch;
      TopologyChange change = cutter.Cut(mesh, surface, &report, &positions);
      const double ms = watch.Wall_ms(), cpu = watch.Cpu_ms();
      positions = change.MapVertexField(positions);
      mesh = std::move(change.mesh);
      if (columns < 4) continue;
      seconds += ms / 4000;
      wall_ms.push_back(ms);
      cpu_ms.push_back(cpu);
      new_tets += report.new_tets;
      area_mm2 += report.cut_area_mm2;
      angle_deg = std::min(angle_deg, report.smallest_dihedral_deg);
    }
    state.SetIterationTime(seconds);
  }
  ReportPercentiles(state, wall_ms, cpu_ms);
  state.counters["new_tets_per_cm2"] = area_mm2 > 0 ? 100.0 * new_tets / area_mm2 : 0;
  state.counters["smallest_dihedral_deg"] = angle_deg;
}

const bool registered = [] {
  for (int n : {5, 9, 13, 17})
    benchmark::RegisterBenchmark(("Cutting/increment/" + std::to_string(20 * n * n * n)).c_str(),
                                 [n](benchmark::State& state) { CuttingIncrement(state, n); })
        ->UseManualTime()
        ->Unit(benchmark::kMillisecond)
        ->Iterations(10);
  return true;
}();

}  // namespace
}  // namespace kerf::testing
