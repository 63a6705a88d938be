#include "Registration/Reliability.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "Registration/Step.h"

namespace kerf {
namespace {

constexpr double kInlier_mm =
    3.0;  // a feature farther from its model point than this speaks against the model
// 1 σ of what no residual shows: the accepted registration and the segmentation, mm, and depth, per
// mm of mean feature motion (docs/reference/tracking.md).
constexpr double kAtRest_mm = 0.8, kDepthShare = 0.3;
constexpr double kGreen = 0.5, kAmber = 0.2;  // scores from which the gate lets through
constexpr std::size_t kNeighbours = 6;        // of a neighbourhood, the feature itself included
constexpr double kBesideSpacings = 2.5;       // a feature this near covers a place
constexpr int kOutlinePoints = 20;            // fewer say nothing

double Ramp(double value, double bad, double good) {
  return std::clamp((value - bad) / (good - bad), 0.0, 1.0);
}

double Median(std::vector<double> values) {
  const std::size_t middle = values.size() / 2;
  std::nth_element(values.begin(), values.begin() + middle, values.end());
  return values[middle];
}

bool HasTumour(const RegistrationState& state) {
  return std::any_of(state.structures.begin(), state.structures.end(),
                     [](const Structure& s) { return s.name == "tumour"; });
}

/// Reprojection errors of the features that are seen.
struct Residuals {
  std::vector<char> seen;  ///< N: tracked and bound
  Pixels mm;               ///< N×2, image minus model at the model's depth
  std::vector<double> seen_mm, seen_px;
  double motion_mm = 0.0;  ///< mean distance from rest of the seen ones
};

Residuals MeasureResiduals(const RegistrationState& state, const CameraModel& camera) {
  const Points current = state.bound.embedding.Positions(state.positions, state.mesh.tets);
  const Index n = state.features.Size();
  Residuals out;
  out.seen.assign(n, 0);
  out.mm = Pixels::Zero(n, 2);
  for (Index i = 0; i < n; ++i) {
    if (state.features.status[i] != FeatureStatus::Tracked || !state.bound.on_surface[i]) continue;
    const Vec3 p = current.row(i).transpose();
    const Vec2 off_px = state.features.pixels.row(i).transpose() - camera.Project(p);
    if (!off_px.allFinite()) continue;
    out.seen[i] = 1;
    out.mm.row(i) = off_px.transpose() * (camera.Depth(p) / camera.fx);
    out.seen_px.push_back(off_px.norm());
    out.seen_mm.push_back(out.mm.row(i).norm());
    out.motion_mm += (p - state.bound.rest.row(i).transpose()).norm();
  }
  out.motion_mm /= std::max<double>(1.0, double(out.seen_px.size()));
  return out;
}

/// Median residual of a feature and the seen ones nearest to it at rest, where that is largest. One
/// wrong feature does not move it, a region does.
double LocalMisfit_mm(const FeatureTriangulation& at_rest, const Residuals& residuals) {
  double worst = 0.0;
  for (std::size_t i = 0; i < at_rest.near.size(); ++i) {
    if (!residuals.seen[i]) continue;
    std::vector<double> around{residuals.mm.row(i).norm()};
    for (const Index j : at_rest.near[i]) {
      if (around.size() == kNeighbours) break;
      if (residuals.seen[j]) around.push_back(residuals.mm.row(j).norm());
    }
    if (around.size() == kNeighbours) worst = std::max(worst, Median(std::move(around)));
  }
  return worst;
}

/// Share of the features bound at the start that have an inlier at or beside them.
double Coverage(const RegistrationState& state, const std::vector<char>& inlier, double reach_mm) {
  Index all = 0, covered = 0;
  const Points& rest = state.bound.rest;
  for (Index i = 0; i < rest.rows(); ++i) {
    if (!state.bound.on_surface[i]) continue;
    ++all;
    for (Index j = 0; j < rest.rows(); ++j)
      if (inlier[j] && (rest.row(i) - rest.row(j)).squaredNorm() < reach_mm * reach_mm) {
        ++covered;
        break;
      }
  }
  return double(covered) / std::max<Index>(1, all);
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
                              Index initially_tracked, const StepReport* step) {
  Reliability out;
  const Residuals residuals = MeasureResiduals(state, camera);
  if (residuals.seen_px.empty()) {
    out.reason = "no feature is tracked";
    out.tumour_u95_mm = HasTumour(state) ? 99.0 : std::numeric_limits<double>::quiet_NaN();
    return out;
  }
  const FeatureTriangulation& at_rest = state.evidence.triangulation;
  std::vector<char> inlier(residuals.seen.size());
  for (std::size_t i = 0; i < inlier.size(); ++i)
    inlier[i] = residuals.seen[i] && residuals.mm.row(i).norm() < kInlier_mm;
  out.residual_mm = Median(residuals.seen_mm);
  out.residual_px = Median(residuals.seen_px);
  out.inliers = double(std::count(inlier.begin(), inlier.end(), 1)) /
                std::max<double>(1.0, double(initially_tracked));
  out.coverage = Coverage(state, inlier, kBesideSpacings * at_rest.spacing_mm);
  out.local_misfit_mm = LocalMisfit_mm(at_rest, residuals);
  if (step && step->outline_points >= kOutlinePoints) out.outline_off = step->outline_off;

  // Where only a part of the organ is off the rest still helps: amber at worst.
  struct Part {
    double score;
    const char* reason;
  };
  const auto partly = [](double score) { return std::max(kAmber, score); };
  const Part parts[] = {
      {Ramp(out.inliers, 0.15, 0.5), "too few features agree with the model"},
      {Ramp(-out.residual_mm, -4.0, -1.0), "the model does not fit the image"},
      {partly(Ramp(-out.local_misfit_mm, -6.5, -1.5)),
       "part of the organ does not fit: a cut not seen?"},
      {partly(Ramp(out.coverage, 0.6, 1.0)), "features were lost in a part of the organ"},
      {partly(Ramp(-out.outline_off, -0.8, -0.2)), "the outline does not fit the image"}};
  const Part* worst = &parts[0];
  for (const Part& part : parts)
    if (part.score < worst->score) worst = &part;
  out.score = worst->score;
  out.state = out.score >= kGreen   ? GateState::Green
              : out.score >= kAmber ? GateState::Amber
                                    : GateState::Off;
  out.reason = out.state == GateState::Green ? "ok" : worst->reason;
  const double unseen_mm = std::hypot(kAtRest_mm, kDepthShare * residuals.motion_mm);
  out.tumour_u95_mm = HasTumour(state) ? 1.96 * std::hypot(out.residual_mm, unseen_mm)
                                       : std::numeric_limits<double>::quiet_NaN();
  return out;
}

}  // namespace kerf
