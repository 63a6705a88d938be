#include "PlanningContour.h"

#include "Adapters/Itk/Contour.h"
#include "Adapters/Itk/WorkingGrid.h"
#include "Core/Errors.h"
#include "Session/PlanningBox.h"

namespace kerf {
namespace {

constexpr int kSteps = 10, kIterationsPerStep = 4;
constexpr double kMargin_mm = 12;

}  // namespace

void EvolveContour(const Volume& ct, const LabelMap& labels, int label, LabelVoxels* voxels,
                   const std::function<void()>& step, Progress& progress) {
  LabelBox box = BoxOf(labels, [label](std::uint8_t v) { return v == label; });
  if (box.Empty())
    throw UsageError("The selected label is empty: paint or grow a start for the contour first.");
  box.Grow(labels.grid, kMargin_mm);
  const GridGeometry grid = CropGrid(ct.grid, box.low, box.high);
  SubProgress sampling(progress, 0.0, 0.1);
  const ScalarField edges = EdgeStrength(Sample(ct, grid, sampling), sampling);
  Mask mask(grid, 0);
  // An organ's contour goes around what lies in it.
  box.ForEach(labels.grid, [&](std::size_t at, std::size_t in_box) {
    const std::uint8_t v = (*labels.voxels)[at];
    mask.values[in_box] = label == 1 ? v >= 1 && v <= 3 : v == label;
  });
  ScalarField inside = SignedDistance_mm(mask);
  for (int s = 0; s < kSteps; ++s) {
    SubProgress part(progress, 0.1 + 0.9 * s / kSteps, 0.1 + 0.9 * (s + 1) / kSteps);
    inside = SnapToEdges(edges, inside, kIterationsPerStep, part);
    progress.ThrowIfCancelled();
    if (voxels->empty()) *voxels = *labels.voxels;
    box.ForEach(labels.grid, [&](std::size_t at, std::size_t in_box) {
      const std::uint8_t v = (*labels.voxels)[at];
      if (v != 0 && v != label) return;
      (*voxels)[at] = inside.values[in_box] >= 0 ? static_cast<std::uint8_t>(label) : 0;
    });
    step();
  }
}

}  // namespace kerf
