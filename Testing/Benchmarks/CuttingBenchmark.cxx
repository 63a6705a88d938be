/// A cut through 40 mm of tissue that grows by 10 mm an increment, in an ellipsoid of 120 × 80 × 40
/// mm. Times are of the increments in the middle of the cut, where each opens about 4 cm².
#include <benchmark/benchmark.h>

#include <string>
#include <utility>

#include "Benchmarks/Percentiles.h"
#include "Cutting/ExtrudePolyline.h"
#include "Cutting/SurfaceIndex.h"
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

enum class Way { Snapping, Plain, Deleting };

/// What a complete cut costs in nodes, tetrahedra, angle and volume: Kerf, subdivision without
/// snapping, and deleting the tetrahedra that meet S.
void CuttingComparison(benchmark::State& state, const TetMesh& mesh, const CutSurface& surface,
                       Way way) {
  CutOptions plain;
  plain.snapping = false;
  CutReport report;
  TopologyChange change;
  for (auto _ : state)
    change = TetCutter(way == Way::Plain ? plain : CutOptions{}).Cut(mesh, surface, &report);
  const double cm2 = report.cut_area_mm2 / 100;
  if (way == Way::Deleting) {
    const SurfaceIndex index(surface);
    Index deleted = 0;
    double lost_mm3 = 0, all_mm3 = 0;
    std::vector<double> hits;
    for (Index t = 0; t < mesh.TetCount(); ++t) {
      const double volume = TetVolume(mesh.rest, mesh.tets, t);
      all_mm3 += volume;
      bool meets = false;
      for (int i = 0; i < 4; ++i)
        for (int k = i + 1; k < 4; ++k) {
          index.Crossings(mesh.rest.row(mesh.tets(t, i)).transpose(),
                          mesh.rest.row(mesh.tets(t, k)).transpose(), &hits);
          meets = meets || !hits.empty();
        }
      if (!meets) continue;
      ++deleted;
      lost_mm3 += volume;
    }
    state.counters["nodes_per_cm2"] = 0;
    state.counters["tets_per_cm2"] = -deleted / cm2;
    state.counters["smallest_dihedral_deg"] = MeasureQuality(mesh, mesh.rest).smallest_dihedral_deg;
    state.counters["volume_lost_percent"] = 100 * lost_mm3 / all_mm3;
    return;
  }
  state.counters["nodes_per_cm2"] = report.new_vertices / cm2;
  state.counters["tets_per_cm2"] = report.new_tets / cm2;
  state.counters["smallest_dihedral_deg"] = report.smallest_dihedral_deg;
  state.counters["volume_lost_percent"] = 0;
}

void RegisterComparison(const std::string& name, const TetMesh& mesh, const CutSurface& surface) {
  for (const auto& [way, label] : {std::pair{Way::Snapping, "kerf"}, std::pair{Way::Plain, "plain"},
                                   std::pair{Way::Deleting, "deleting"}})
    benchmark::RegisterBenchmark(("Cutting/comparison/" + name + "/" + label).c_str(),
                                 [mesh, surface, way = way](benchmark::State& state) {
                                   CuttingComparison(state, mesh, surface, way);
                                 })
        ->Unit(benchmark::kMillisecond)
        ->Iterations(1);
}

const bool registered = [] {
  RegisterComparison("ellipsoid", EllipsoidMesh({60, 40, 20}, 9), CutUpTo(12));
  RegisterComparison("band", BandMesh(6000),
                     RectangleCut({3.1, -30, -8}, {9, 60, 0}, {0, 0, 16}, 30, 8));
  RegisterComparison("irregular", Jitter(BoxMesh({40, 40, 40}, 10, 10, 10), 0.7, 8, 4),
                     RectangleCut({1.3, -30, -25}, {0.9, 60, 0}, {0, 5, 60}, 30, 30));
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
