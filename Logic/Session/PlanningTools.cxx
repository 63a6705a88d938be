#include "Session/PlanningTools.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>

#include "Core/Errors.h"
#include "Session/PlanningBox.h"

namespace kerf {
namespace {

std::string Ml(double value) {
  char text[32];
  std::snprintf(text, sizeof text, value < 10 ? "%.1f ml" : "%.0f ml", value);
  return text;
}

std::string NameOf(int label) {
  return label == 1 ? "organ" : label == 2 ? "tumour" : label == 3 ? "inner structure" : "label";
}

}  // namespace

LabelVoxels ThresholdTool(const Volume& ct, const LabelMap& labels, int label, int low_hu,
                          int high_hu, int within, Progress& progress) {
  LabelVoxels out = *labels.voxels;
  const std::size_t slice = std::size_t(labels.grid.size[0]) * labels.grid.size[1];
  for (int k = 0; k < labels.grid.size[2]; ++k) {
    progress.ThrowIfCancelled();
    progress.Report(double(k) / labels.grid.size[2], "threshold");
    for (std::size_t v = k * slice; v < (k + 1) * slice; ++v) {
      const int hu = (*ct.voxels)[v];
      if (hu >= low_hu && hu <= high_hu && (within < 0 || out[v] == within))
        out[v] = static_cast<std::uint8_t>(label);
    }
  }
  return out;
}

LabelVoxels GrowTool(const Volume& ct, const LabelMap& labels, int label,
                     const Eigen::Vector3i& seed, double tolerance_hu, double reach_mm,
                     Progress& progress) {
  const GridGeometry& grid = ct.grid;
  if ((seed.array() < 0).any() || (seed.array() >= grid.size.array()).any())
    throw InputError(ct.source, "seed", "the seed lies outside the CT; click inside the picture");
  double sum = 0;
  int count = 0;
  for (int k = std::max(0, seed[2] - 1); k <= std::min(grid.size[2] - 1, seed[2] + 1); ++k)
    for (int j = std::max(0, seed[1] - 1); j <= std::min(grid.size[1] - 1, seed[1] + 1); ++j)
      for (int i = std::max(0, seed[0] - 1); i <= std::min(grid.size[0] - 1, seed[0] + 1); ++i)
        sum += (*ct.voxels)[grid.Offset(i, j, k)], ++count;
  const double mean = sum / count;
  const Vec3 center = seed.cast<double>();
  LabelVoxels out = *labels.voxels;
  const auto takes = [&](const Eigen::Vector3i& p, std::size_t at) {
    if (out[at] != 0 && out[at] != label) return false;
    if (std::abs((*ct.voxels)[at] - mean) > tolerance_hu) return false;
    return (p.cast<double>() - center).cwiseProduct(grid.spacing_mm).norm() <= reach_mm;
  };
  std::vector<char> seen(out.size(), 0);
  std::vector<Eigen::Vector3i> front{seed};
  seen[grid.Offset(seed[0], seed[1], seed[2])] = 1;
  std::size_t done = 0;
  while (!front.empty()) {
    if ((++done & 0xffff) == 0) {
      progress.ThrowIfCancelled();
      progress.Report(std::min(0.95, double(done) * 20.0 / double(out.size())), "growing");
    }
    const Eigen::Vector3i p = front.back();
    front.pop_back();
    const std::size_t at = grid.Offset(p[0], p[1], p[2]);
    // The seed itself is always taken: a person pointed at it.
    out[at] = static_cast<std::uint8_t>(label);
    for (int side = 0; side < 6; ++side) {
      Eigen::Vector3i q = p;
      q[side / 2] += side % 2 ? 1 : -1;
      if (q[side / 2] < 0 || q[side / 2] >= grid.size[side / 2]) continue;
      const std::size_t next = grid.Offset(q[0], q[1], q[2]);
      if (seen[next] || !takes(q, next)) continue;
      seen[next] = 1;
      front.push_back(q);
    }
  }
  return out;
}

LabelVoxels RemoveIslandsTool(const LabelMap& labels, int label, double least_ml,
                              Progress& progress) {
  LabelVoxels out = *labels.voxels;
  const LabelBox box = BoxOf(labels, [label](std::uint8_t v) { return v == label; });
  if (box.Empty()) return out;
  const BoxComponents parts = ComponentsIn(
      labels, box, [label](std::uint8_t v) { return v == label; }, progress);
  const double least = least_ml * 1000.0 / labels.grid.VoxelVolume_mm3();
  box.ForEach(labels.grid, [&](std::size_t at, std::size_t in_box) {
    const std::int32_t part = parts.of[in_box];
    if (part > 0 && double(parts.sizes[part - 1]) < least) out[at] = 0;
  });
  return out;
}

LabelVoxels KeepLargestTool(const LabelMap& labels, int label, Progress& progress) {
  LabelVoxels out = *labels.voxels;
  const auto test = [label](std::uint8_t v) { return label == 0 ? v != 0 : v == label; };
  const LabelBox box = BoxOf(labels, test);
  if (box.Empty()) return out;
  const BoxComponents parts = ComponentsIn(labels, box, test, progress);
  const int largest = parts.Largest();
  box.ForEach(labels.grid, [&](std::size_t at, std::size_t in_box) {
    if (parts.of[in_box] > 0 && parts.of[in_box] != largest) out[at] = 0;
  });
  return out;
}

LabelVoxels FillHolesTool(const LabelMap& labels, int label, Progress& progress) {
  LabelVoxels out = *labels.voxels;
  LabelBox box = BoxOf(labels, [](std::uint8_t v) { return v != 0; });
  if (box.Empty()) return out;
  const BoxComponents outside = ComponentsIn(
      labels, box, [](std::uint8_t v) { return v == 0; }, progress);
  const std::vector<char> open = TouchesFace(box, outside);
  box.ForEach(labels.grid, [&](std::size_t at, std::size_t in_box) {
    const std::int32_t part = outside.of[in_box];
    if (part > 0 && !open[part - 1]) out[at] = static_cast<std::uint8_t>(label);
  });
  return out;
}

LabelVoxels SmoothTool(const LabelMap& labels, int label, double radius_mm, Progress& progress) {
  LabelVoxels out = *labels.voxels;
  LabelBox box = BoxOf(labels, [label](std::uint8_t v) { return v == label; });
  if (box.Empty()) return out;
  box.Grow(labels.grid, radius_mm + 1);
  std::vector<float> field(box.Count(), 0.f), line;
  box.ForEach(labels.grid, [&](std::size_t at, std::size_t in_box) {
    field[in_box] = (*labels.voxels)[at] == label ? 1.f : 0.f;
  });
  // Two box filters along each axis: nearly a Gaussian.
  const Eigen::Vector3i n = box.Size();
  for (int axis = 0; axis < 3; ++axis)
    for (int pass = 0; pass < 2; ++pass) {
      progress.ThrowIfCancelled();
      progress.Report((2 * axis + pass) / 6.0, "smoothing");
      const int r = static_cast<int>(std::lround(0.6 * radius_mm / labels.grid.spacing_mm[axis]));
      if (r < 1) continue;
      box.ForEachLine(axis, [&](std::size_t first, std::size_t stride) {
        line.resize(n[axis]);
        float sum = 0;
        for (int i = 0; i < std::min(r, n[axis]); ++i) sum += field[first + i * stride];
        for (int i = 0; i < n[axis]; ++i) {
          if (i + r < n[axis]) sum += field[first + (i + r) * stride];
          if (i - r - 1 >= 0) sum -= field[first + (i - r - 1) * stride];
          line[i] = sum / float(2 * r + 1);
        }
        for (int i = 0; i < n[axis]; ++i) field[first + i * stride] = line[i];
      });
    }
  // A half as level would make whatever is round smaller: the level is the one that keeps the
  // volume.
  std::vector<float> values;
  std::size_t before = 0;
  box.ForEach(labels.grid, [&](std::size_t at, std::size_t in_box) {
    const std::uint8_t now = out[at];
    before += now == label;
    if (now == 0 || now == label) values.push_back(field[in_box]);
  });
  float level = 0.5f;
  if (before < values.size()) {
    const auto nth = values.begin() + static_cast<std::ptrdiff_t>(before);
    std::nth_element(values.begin(), nth, values.end(), std::greater<float>());
    level = std::clamp(*nth, 0.35f, 0.65f);
  }
  box.ForEach(labels.grid, [&](std::size_t at, std::size_t in_box) {
    const std::uint8_t now = out[at];
    if (now != 0 && now != label) return;
    out[at] = field[in_box] > level ? static_cast<std::uint8_t>(label) : 0;
  });
  return out;
}

LabelVoxels BooleanTool(const LabelMap& labels, int label, int other, BooleanOperation operation,
                        double reach_mm, Progress& progress) {
  const auto own = static_cast<std::uint8_t>(label), second = static_cast<std::uint8_t>(other);
  LabelVoxels out = *labels.voxels;
  const std::vector<std::uint8_t> near = MarginVoxels(labels, other, reach_mm, progress);
  for (std::size_t v = 0; v < out.size(); ++v) {
    const bool held = near[v] || out[v] == second;
    if (operation == BooleanOperation::Add && held && (out[v] == 0 || out[v] == second))
      out[v] = own;
    if (operation == BooleanOperation::Subtract && held && out[v] == own) out[v] = 0;
    if (operation == BooleanOperation::Intersect && !held && out[v] == own) out[v] = 0;
  }
  return out;
}

LabelVoxels MapLabels(const LabelMap& labels, const std::map<int, int>& role_of,
                      const GridGeometry& grid, Progress& progress) {
  std::array<std::uint8_t, 256> role{};
  for (const auto& [value, to] : role_of)
    if (value >= 0 && value < 256) role[value] = static_cast<std::uint8_t>(to);
  LabelVoxels out(grid.VoxelCount(), 0);
  const bool same = labels.grid.SameAs(grid);
  // Index in the label map is affine in the CT's index.
  const Vec3 origin = labels.grid.IndexFromWorld(grid.WorldFromIndex(Vec3::Zero()));
  const Vec3 step = labels.grid.IndexFromWorld(grid.WorldFromIndex(Vec3::UnitX())) - origin;
  std::size_t taken = 0, at = 0;
  for (int k = 0; k < grid.size[2]; ++k) {
    progress.ThrowIfCancelled();
    progress.Report(double(k) / grid.size[2], "reading labels");
    for (int j = 0; j < grid.size[1]; ++j) {
      Vec3 index = labels.grid.IndexFromWorld(grid.WorldFromIndex(Vec3(0, j, k)));
      for (int i = 0; i < grid.size[0]; ++i, ++at, index += step) {
        std::size_t from = at;
        if (!same) {
          const Eigen::Vector3i near = index.array().round().cast<int>();
          if ((near.array() < 0).any() || (near.array() >= labels.grid.size.array()).any())
            continue;
          from = labels.grid.Offset(near[0], near[1], near[2]);
        }
        out[at] = role[(*labels.voxels)[from]];
        taken += out[at] != 0;
      }
    }
  }
  if (taken == 0)
    throw InputError(labels.source, "geometry",
                     "nothing of these labels lies in the CT: they belong to another patient or "
                     "series, or no label was given a meaning");
  return out;
}

std::vector<LabelFinding> CheckLabels(const LabelMap& labels, Progress& progress) {
  std::vector<LabelFinding> findings;
  const auto any = [](std::uint8_t v) { return v >= 1 && v <= 3; };
  const LabelBox box = BoxOf(labels, any);
  if (box.Empty()) {
    findings.push_back({LabelFinding::Kind::Empty, 1,
                        "Nothing is labelled yet: use a preset, or paint the organ."});
    return findings;
  }
  const double voxel_ml = labels.grid.VoxelVolume_mm3() / 1000.0;
  const BoxComponents parts = ComponentsIn(labels, box, any, progress);
  if (parts.sizes.size() > 1) {
    std::size_t rest = 0;
    for (const std::size_t s : parts.sizes) rest += s;
    rest -= parts.sizes[parts.Largest() - 1];
    findings.push_back({LabelFinding::Kind::Islands, 1,
                        "The organ has " + std::to_string(parts.sizes.size()) + " pieces (" +
                            Ml(double(rest) * voxel_ml) +
                            " apart from the largest). Keep the largest, or connect them."});
  }
  const BoxComponents outside = ComponentsIn(
      labels, box, [](std::uint8_t v) { return v == 0; }, progress);
  const std::vector<char> open = TouchesFace(box, outside);
  std::size_t holes = 0, voxels = 0;
  for (std::size_t p = 0; p < outside.sizes.size(); ++p)
    if (!open[p]) ++holes, voxels += outside.sizes[p];
  if (holes > 0)
    findings.push_back({LabelFinding::Kind::Holes, 1,
                        "The organ has " + std::to_string(holes) +
                            (holes == 1 ? " hole (" : " holes (") + Ml(double(voxels) * voxel_ml) +
                            "). Fill them."});
  const Eigen::Vector3i last = labels.grid.size - Eigen::Vector3i::Ones();
  if ((box.low.array() <= 0).any() || (box.high.array() >= last.array()).any())
    findings.push_back({LabelFinding::Kind::Border, 1,
                        "The organ reaches the border of the CT: it is cut off there. Use a CT "
                        "that shows all of it, or erase what leaked."});
  for (const int label : {2, 3}) {
    const LabelBox own = BoxOf(labels, [label](std::uint8_t v) { return v == label; });
    if (own.Empty()) continue;
    const int largest = parts.Largest();
    std::size_t away = 0;
    own.ForEach(labels.grid, [&](std::size_t at, std::size_t) {
      if ((*labels.voxels)[at] != label) return;
      away += parts.of[box.InBox(labels.grid, at)] != largest;
    });
    if (away > 0)
      findings.push_back({LabelFinding::Kind::OutsideOrgan, label,
                          Ml(double(away) * voxel_ml) + " of the " + NameOf(label) +
                              " do not touch the organ and will be left out. Remove islands, or "
                              "correct the organ."});
  }
  return findings;
}

std::vector<std::uint8_t> MarginVoxels(const LabelMap& labels, int label, double margin_mm,
                                       Progress& progress) {
  std::vector<std::uint8_t> mask(labels.grid.VoxelCount(), 0);
  LabelBox box = BoxOf(labels, [label](std::uint8_t v) { return v == label; });
  if (box.Empty()) return mask;
  box.Grow(labels.grid, margin_mm + labels.grid.spacing_mm.maxCoeff());
  const std::vector<float> distance2 = SquaredDistance_mm2(
      labels, box, [label](std::uint8_t v) { return v == label; }, progress);
  const auto most = static_cast<float>(margin_mm * margin_mm);
  box.ForEach(labels.grid, [&](std::size_t at, std::size_t in_box) {
    mask[at] = distance2[in_box] > 0 && distance2[in_box] <= most;
  });
  return mask;
}

}  // namespace kerf
