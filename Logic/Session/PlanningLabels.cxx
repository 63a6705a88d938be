#include "Session/PlanningLabels.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace kerf {

std::vector<LabelInfo> StandardLabels() {
  return {{1, "organ", "Organ", {201, 112, 92}, true},
          {2, "tumour", "Tumour", {242, 201, 76}, true},
          {3, "internal", "Vessels, calyces", {86, 160, 236}, true}};
}

LabelDelta Difference(const std::vector<std::uint8_t>& before,
                      const std::vector<std::uint8_t>& after) {
  LabelDelta delta;
  for (std::size_t i = 0; i < before.size(); ++i) {
    if (before[i] == after[i]) continue;
    if (!delta.runs.empty()) {
      LabelDelta::Run& last = delta.runs.back();
      if (last.offset + last.length == i && last.before == before[i] && last.after == after[i]) {
        ++last.length;
        continue;
      }
    }
    delta.runs.push_back({i, 1, before[i], after[i]});
  }
  return delta;
}

LabelEdit CompareLabels(const LabelMap& before, std::vector<std::uint8_t> after) {
  if (after.size() != before.voxels->size()) throw std::invalid_argument("label map: voxel count");
  LabelEdit edit;
  edit.before = before.voxels;
  edit.delta = Difference(*before.voxels, after);
  edit.after = std::make_shared<std::vector<std::uint8_t>>(std::move(after));
  return edit;
}

CountedLabels CountLabels(LabelMap labels) {
  if (!labels.voxels || labels.voxels->size() != labels.grid.VoxelCount())
    throw std::invalid_argument("label map: voxel count");
  CountedLabels counted;
  for (const std::uint8_t v : *labels.voxels) ++counted.counts[v];
  counted.labels = std::move(labels);
  return counted;
}

CountedLabels NoLabels(const GridGeometry& grid, const std::string& source) {
  CountedLabels empty;
  empty.labels.grid = grid;
  empty.labels.source = source;
  empty.labels.voxels = std::make_shared<const std::vector<std::uint8_t>>(grid.VoxelCount(), 0);
  empty.counts[0] = grid.VoxelCount();
  return empty;
}

void LabelEditor::Reset(const GridGeometry& grid, const std::string& source) {
  Reset(NoLabels(grid, source));
}

void LabelEditor::Reset(const CountedLabels& counted) {
  labels_ = LabelMap();
  labels_.grid = counted.labels.grid;
  labels_.source = counted.labels.source;
  labels_.voxels = counted.labels.voxels;
  for (const LabelInfo& info : StandardLabels()) labels_.names[info.value] = info.name;
  voxels_.reset();
  counts_ = counted.counts;
  ++revision_;
}

double LabelEditor::Volume_ml(int label) const {
  return static_cast<double>(counts_[label]) * labels_.grid.VoxelVolume_mm3() / 1000.0;
}

std::vector<std::uint8_t>& LabelEditor::Writable() {
  // Two owners are this class's own: voxels_ and labels_.voxels.
  if (!voxels_ || voxels_.use_count() > 2) {
    voxels_ = std::make_shared<std::vector<std::uint8_t>>(*labels_.voxels);
    labels_.voxels = voxels_;
  }
  ++revision_;
  return *voxels_;
}

void LabelEditor::Apply(const LabelDelta& delta, bool forwards) {
  std::vector<std::uint8_t>& voxels = Writable();
  for (const LabelDelta::Run& run : delta.runs) {
    const std::uint8_t from = forwards ? run.before : run.after;
    const std::uint8_t to = forwards ? run.after : run.before;
    std::fill_n(voxels.begin() + static_cast<std::ptrdiff_t>(run.offset), run.length, to);
    counts_[from] -= run.length;
    counts_[to] += run.length;
  }
}

LabelDelta LabelEditor::Replace(const LabelEdit& edit) {
  // What was handed out never changes: the same voxels are an unchanged map.
  if (edit.before != labels_.voxels) return Replace(CompareLabels(labels_, *edit.after));
  for (const LabelDelta::Run& run : edit.delta.runs) {
    counts_[run.before] -= run.length;
    counts_[run.after] += run.length;
  }
  labels_.voxels = voxels_ = edit.after;
  ++revision_;
  return edit.delta;
}

void LabelEditor::BeginStroke() { stroke_.clear(); }

void LabelEditor::Dab(const Brush& brush, const Vec3& center, const Volume* ct) {
  const GridGeometry& grid = labels_.grid;
  Eigen::Vector3i low, high;
  for (int a = 0; a < 3; ++a) {
    const double reach = a == brush.flat_axis ? 0.0 : brush.radius_mm / grid.spacing_mm[a];
    low[a] = std::max(0, static_cast<int>(std::ceil(center[a] - reach)));
    high[a] = std::min(grid.size[a] - 1, static_cast<int>(std::floor(center[a] + reach)));
    if (a == brush.flat_axis)
      low[a] = high[a] = std::clamp(static_cast<int>(std::lround(center[a])), 0, grid.size[a] - 1);
  }
  std::vector<std::uint8_t>& voxels = Writable();
  const double radius2 = brush.radius_mm * brush.radius_mm;
  for (int k = low[2]; k <= high[2]; ++k)
    for (int j = low[1]; j <= high[1]; ++j)
      for (int i = low[0]; i <= high[0]; ++i) {
        Vec3 d = (Vec3(i, j, k) - center).cwiseProduct(grid.spacing_mm);
        if (brush.flat_axis >= 0) d[brush.flat_axis] = 0;
        if (d.squaredNorm() > radius2) continue;
        const std::size_t at = grid.Offset(i, j, k);
        const std::uint8_t before = voxels[at];
        if (before == brush.paint) continue;
        if (brush.only_over >= 0 && before != brush.only_over) continue;
        if (ct) {
          const int hu = (*ct->voxels)[at];
          if (hu < brush.low_hu || hu > brush.high_hu) continue;
        }
        stroke_.emplace_back(at, before);
        voxels[at] = brush.paint;
        --counts_[before];
        ++counts_[brush.paint];
      }
}

LabelDelta LabelEditor::EndStroke() {
  // A voxel that was painted over twice had its first value before.
  std::stable_sort(stroke_.begin(), stroke_.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  LabelDelta delta;
  for (std::size_t s = 0; s < stroke_.size(); ++s) {
    const auto [at, before] = stroke_[s];
    if (s > 0 && stroke_[s - 1].first == at) continue;
    const std::uint8_t after = (*labels_.voxels)[at];
    if (before == after) continue;
    if (!delta.runs.empty()) {
      LabelDelta::Run& last = delta.runs.back();
      if (last.offset + last.length == at && last.before == before && last.after == after) {
        ++last.length;
        continue;
      }
    }
    delta.runs.push_back({at, 1, before, after});
  }
  stroke_.clear();
  return delta;
}

}  // namespace kerf
