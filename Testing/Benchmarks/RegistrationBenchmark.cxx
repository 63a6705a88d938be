/// Two stages of a frame that are there for topology, by themselves. `Detection/<features>`: a flat
/// organ is stretched under noise, and from the middle on a crack runs into it; everything that
/// looks for cuts and draws their lines (goal: ≤ 0.15 ms a frame at 225). `Structures/<points>`:
/// points of inner structures follow a mesh of 14,580 tetrahedra (goal: ≤ 0.25 ms at 20,000).
#include <benchmark/benchmark.h>

#include <random>

#include "Benchmarks/Percentiles.h"
#include "Geometry/EmbedPoints.h"
#include "Logic/Registration/CutMotion.h"
#include "Registration/JumpDetection.h"
#include "Support/TestCameras.h"
#include "Support/TestMeshes.h"

namespace kerf::testing {
namespace {

constexpr int kFrames = 100;
constexpr double kNoise_mm = 0.03;
constexpr double kLong_mm = 85.5, kWide_mm = 36.0, kDepth_mm = 150.0;

/// A slab below evenly strewn features; the world is the camera.
struct CutScene {
  explicit CutScene(int features) : camera(Pinhole(640, 480, 700.0)), rest(features, 3) {
    const double spacing = std::sqrt(kLong_mm * kWide_mm / features);
    const int columns = std::max(1, static_cast<int>(kLong_mm / spacing));
    const int rows = (features + columns - 1) / columns;
    std::uniform_real_distribution<double> jitter(-0.3, 0.3);
    for (int i = 0; i < features; ++i)
      rest.row(i) << kLong_mm * (i % columns + 0.5 + jitter(random)) / columns,
          kWide_mm * (i / columns + 0.5 + jitter(random)) / rows, kDepth_mm;
    state.mesh = BoxMesh(Vec3(94.0, 44.0, 20.0), 12, 6, 3);
    const Eigen::RowVector3d low = state.mesh.rest.colwise().minCoeff();
    state.mesh.rest.rowwise() += Eigen::RowVector3d(-4.0, -4.0, kDepth_mm) - low;
    state.positions = state.mesh.rest;
    state.uncut = std::make_shared<SurfaceTree>(BoundarySurface(state.mesh, state.mesh.rest));
    usable.assign(features, 1);
    state.evidence = BeginEvidence(rest, usable);
    std::normal_distribution<double> noise(0.0, kNoise_mm);
    for (int f = 0; f < kFrames; ++f) {
      Pixels now(features, 2);
      for (int i = 0; i < features; ++i) {
        const Vec2 place = Cut(rest.row(i).head<2>().transpose(), f / (kFrames - 1.0));
        now(i, 0) = place.x() + noise(random);
        now(i, 1) = place.y() + noise(random);
      }
      motion.push_back(std::move(now));
    }
  }

  std::mt19937 random{3};
  CameraModel camera;
  Points rest;
  std::vector<char> usable;
  std::vector<Pixels> motion;
  RegistrationState state;
};

void Detection(benchmark::State& state) {
  const CutScene scene(static_cast<int>(state.range(0)));
  const MethodOptions options;
  std::vector<double> wall_ms, cpu_ms;
  double cuts = 0.0;
  for (auto _ : state) {
    state.PauseTiming();
    RegistrationState registration = scene.state;
    state.ResumeTiming();
    for (int f = 0; f < kFrames; ++f) {
      registration.frame = f;
      const Stopwatch watch;
      DetectCutsByJumps(scene.motion[f], scene.usable, scene.camera, options, &registration);
      wall_ms.push_back(watch.Wall_ms());
      cpu_ms.push_back(watch.Cpu_ms());
    }
    cuts += static_cast<double>(registration.cuts.size());
  }
  ReportPercentiles(state, wall_ms, cpu_ms);
  state.counters["cuts"] = cuts / static_cast<double>(state.iterations());
}

void Structures(benchmark::State& state) {
  const TetMesh mesh = EllipsoidMesh({51, 27.5, 13.5}, 9);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> draw(-1.0, 1.0);
  Points inside(state.range(0), 3);
  for (Index i = 0; i < inside.rows();) {
    const Vec3 p(draw(random), draw(random), draw(random));
    if (p.norm() < 0.7) inside.row(i++) << 51 * p.x(), 27.5 * p.y(), 13.5 * p.z();
  }
  const Embedding embedding = EmbedPoints(mesh, inside);
  const Points positions = 1.1 * mesh.rest;
  Points out;
  std::vector<double> wall_ms, cpu_ms;
  for (auto _ : state) {
    const Stopwatch watch;
    embedding.Positions(positions, mesh.tets, &out);
    wall_ms.push_back(watch.Wall_ms());
    cpu_ms.push_back(watch.Cpu_ms());
  }
  ReportPercentiles(state, wall_ms, cpu_ms);
  state.counters["max_error_mm"] = (out - 1.1 * inside).rowwise().norm().maxCoeff();
}

BENCHMARK(Detection)->Arg(225)->Arg(500)->Arg(1000)->Unit(benchmark::kMillisecond);
BENCHMARK(Structures)->Arg(2000)->Arg(20000)->Arg(100000)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace kerf::testing
