#include <benchmark/benchmark.h>

#include <QApplication>
#include <QImage>

#include "Session/PlanningLabels.h"
#include "Views/qKerfSliceView.h"

/// A 512 × 512 × 300 CT with an organ of about 1.5 l, in three linked views as large as at
/// 1280 × 800. One iteration is what a person waits for: new slice or dab → picture.
namespace {

struct Scene {
  kerf::Volume ct;
  kerf::LabelEditor editor;
  qKerfSliceView axial{kerf::SlicePlane::Axial}, coronal{kerf::SlicePlane::Coronal},
      sagittal{kerf::SlicePlane::Sagittal};

  Scene() {
    ct.grid.size = {512, 512, 300};
    ct.grid.spacing_mm = {0.8, 0.8, 1.0};
    auto voxels = std::make_shared<std::vector<std::int16_t>>(ct.grid.VoxelCount());
    for (std::size_t v = 0; v < voxels->size(); ++v)
      (*voxels)[v] = static_cast<std::int16_t>((v * 2654435761u >> 20) % 400) - 100;
    ct.voxels = voxels;
    editor.Reset(ct.grid, "benchmark");
    kerf::LabelEditor::Brush organ;
    organ.radius_mm = 71;
    editor.BeginStroke();
    editor.Dab(organ, {256, 256, 150}, nullptr);
    editor.EndStroke();
    std::array<std::uint32_t, 256> colors{};
    colors[1] = 0xffc9705cu;
    colors[2] = 0xfff2c94cu;
    for (qKerfSliceView* view : {&axial, &coronal, &sagittal}) {
      view->resize(426, 349);
      view->SetSources(&ct, &editor.Labels());
      view->SetLabelColors(colors);
    }
  }
};

Scene& TheScene() {
  static Scene scene;
  return scene;
}

void Draw(qKerfSliceView& view) {
  QImage image(view.size(), QImage::Format_RGB32);
  view.render(&image);
  benchmark::DoNotOptimize(image.constBits());
}

void ScrollOneView(benchmark::State& state) {
  Scene& scene = TheScene();
  int slice = 100;
  for (auto _ : state) {
    scene.axial.SetSlice(100 + slice++ % 100);
    Draw(scene.axial);
  }
  state.counters["per_s"] =
      benchmark::Counter(double(state.iterations()), benchmark::Counter::kIsRate);
}

void MoveCrosshairOfAllViews(benchmark::State& state) {
  Scene& scene = TheScene();
  int step = 0;
  for (auto _ : state) {
    const kerf::Vec3 index(200 + step % 100, 300 - step % 100, 100 + step % 100);
    ++step;
    for (qKerfSliceView* view : {&scene.axial, &scene.coronal, &scene.sagittal}) {
      view->SetCrosshair(scene.ct.grid.WorldFromIndex(index));
      Draw(*view);
    }
  }
  state.counters["per_s"] =
      benchmark::Counter(double(state.iterations()), benchmark::Counter::kIsRate);
}

void Paint(benchmark::State& state) {
  Scene& scene = TheScene();
  kerf::LabelEditor::Brush brush;
  brush.radius_mm = 15;
  brush.flat_axis = state.range(0) ? -1 : 2;
  brush.paint = 2;
  int step = 0;
  scene.editor.BeginStroke();
  for (auto _ : state) {
    brush.paint = static_cast<std::uint8_t>(1 + step / 100 % 2);
    scene.editor.Dab(brush, kerf::Vec3(150 + step % 100, 256, 150), &scene.ct);
    ++step;
    scene.axial.Refresh();
    Draw(scene.axial);
  }
  scene.editor.EndStroke();
  state.counters["per_s"] =
      benchmark::Counter(double(state.iterations()), benchmark::Counter::kIsRate);
}

}  // namespace

BENCHMARK(ScrollOneView)->Unit(benchmark::kMillisecond);
BENCHMARK(MoveCrosshairOfAllViews)->Unit(benchmark::kMillisecond);
BENCHMARK(Paint)->Arg(0)->Arg(1)->ArgName("ball")->Unit(benchmark::kMillisecond);

int main(int argc, char** argv) {
  QApplication app(argc, argv);
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
