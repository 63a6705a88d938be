#include "Registration/Reliability.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

namespace kerf {
namespace {

constexpr double kInlier_mm =
    3.0;  // a feature farther from its model point than this speaks against the model
constexpr double kDepthShare =
    0.20;  // 1 σ of unseen depth motion per mm of mean feature motion (docs/validation.md)
constexpr int kGrid = 6;  // coverage: cells across the initial feature cloud

double Ramp(double value, double bad, double good) {
  return std::clamp((value - bad) / (good - bad), 0.0, 1.0);
}

/// Cells of the rest cloud (in its two widest world axes) that hold at least one of the given
/// features.
int OccupiedCells(const Points& rest, const std::vector<char>& use) {
  const Vec3 low = rest.colwise().minCoeff().transpose();
  const Vec3 extent = rest.colwise().maxCoeff().transpose() - low;
  std::array<int, 3> axis{0, 1, 2};
  std::sort(axis.begin(), axis.end(), [&](int a, int b) { return extent[a] > extent[b]; });
  std::array<char, kGrid * kGrid> cell{};
  for (Index i = 0; i < rest.rows(); ++i) {
    if (!use[i]) continue;
    int at[2];
    for (int k = 0; k < 2; ++k) {
      const double f = (rest(i, axis[k]) - low[axis[k]]) / std::max(extent[axis[k]], 1e-9);
      at[k] = std::clamp(static_cast<int>(f * kGrid), 0, kGrid - 1);
    }
    cell[at[0] * kGrid + at[1]] = 1;
  }
  return static_cast<int>(std::count(cell.begin(), cell.end(), 1));
}

bool HasTumour(const RegistrationState& state) {
  return std::any_of(state.structures.begin(), state.structures.end(),
                     [](const Structure& s) { return s.name == "tumour"; });
}

}  // namespace

const char* ToString(GateState state) {
  switch (state) {
    case GateState::Green:
      return "green";
    case GateState::Amber:
      return "amber";
    case GateState::Off:
      return "off";
  }
  return "off";
}

Reliability AssessReliability(const RegistrationState& state, const CameraModel& camera,
                              Index initially_tracked) {
  Reliability out;
  const Points current = state.bound.embedding.Positions(state.positions, state.mesh.tets);
  const Index n = state.features.Size();
  std::vector<double> residual_px, residual_mm;
  std::vector<char> everyone(n, 1), inlier(n, 0);
  double motion = 0.0;
  for (Index i = 0; i < n; ++i) {
    everyone[i] = state.bound.on_surface[i];
    if (state.features.status[i] != FeatureStatus::Tracked || !state.bound.on_surface[i]) continue;
    const Vec3 p = current.row(i).transpose();
    const Vec2 projected = camera.Project(p);
    if (!projected.allFinite()) continue;
    const double px = (projected - state.features.pixels.row(i).transpose()).norm();
    const double mm = px * camera.Depth(p) / camera.fx;
    residual_px.push_back(px);
    residual_mm.push_back(mm);
    motion += (p - state.bound.rest.row(i).transpose()).norm();
    inlier[i] = mm < kInlier_mm;
  }
  if (residual_px.empty()) {
    out.reason = "no feature is tracked";
    out.tumour_u95_mm = HasTumour(state) ? 99.0 : std::numeric_limits<double>::quiet_NaN();
    return out;
  }
  const std::size_t middle = residual_px.size() / 2;
  std::nth_element(residual_px.begin(), residual_px.begin() + middle, residual_px.end());
  std::nth_element(residual_mm.begin(), residual_mm.begin() + middle, residual_mm.end());
  motion /= static_cast<double>(residual_px.size());
  out.residual_px = residual_px[middle];
  out.inliers = std::count(inlier.begin(), inlier.end(), 1) /
                std::max(1.0, static_cast<double>(initially_tracked));
  out.coverage = OccupiedCells(state.bound.rest, inlier) /
                 std::max(1.0, static_cast<double>(OccupiedCells(state.bound.rest, everyone)));
  const double by_inliers = Ramp(out.inliers, 0.15, 0.5);
  const double by_coverage = Ramp(out.coverage, 0.25, 0.7);
  const double by_residual = Ramp(-residual_mm[middle], -4.0, -1.0);
  out.score = std::min({by_inliers, by_coverage, by_residual});
  out.state = out.score >= 0.5   ? GateState::Green
              : out.score >= 0.2 ? GateState::Amber
                                 : GateState::Off;
  if (out.state == GateState::Green)
    out.reason = "ok";
  else if (out.score == by_inliers)
    out.reason = "too few features agree with the model";
  else if (out.score == by_coverage)
    out.reason = "features cover too little of the organ";
  else
    out.reason = "the model does not fit the image";
  out.tumour_u95_mm = HasTumour(state)
                          ? 1.96 * std::hypot(residual_mm[middle], kDepthShare * motion)
                          : std::numeric_limits<double>::quiet_NaN();
  return out;
}

}  // namespace kerf
