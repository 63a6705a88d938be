#include "Registration/CutEvidence.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace kerf {
namespace {

constexpr int kLongAway = 5;             // frames after which a feature that comes back
constexpr int kSettledAfter = 8;         // bears no witness for so many
constexpr std::size_t kMemory = 25;      // frames before a proportion is learned: one second
constexpr double kLeastMotion_mm = 0.1;  // below it the proportion is noise
constexpr double kMargin = 1.5;          // on the learned proportion
constexpr double kLeastExcess_mm = 0.8;
constexpr double kNoiseFactor = 5.0;  // excess over the measurement's own noise
constexpr double kNoiseJump = 3.0;    // jumps up to so many σ teach nothing
constexpr int kStreak = 2;
constexpr double kSolitary = 0.65;
constexpr Index kTogether = 256;  // pairs, whose values stay in the nearest cache
constexpr double kRefusedFactor = 2.0, kRefusedMore_mm = 2.0;

}  // namespace

CutEvidence BeginEvidence(const Points& rest_camera, const std::vector<char>& usable) {
  CutEvidence evidence;
  evidence.triangulation = TriangulateFeatures(rest_camera, usable);
  const Index edges = static_cast<Index>(evidence.triangulation.edges.size());
  evidence.learned = Eigen::VectorXd::Zero(edges);
  evidence.streak.assign(edges, 0);
  return evidence;
}

void DoubtReturned(const FeatureTriangulation& t, const std::vector<char>& usable,
                   CutEvidence* evidence, DisplacementJumps* jumps) {
  const std::size_t n = usable.size();
  if (evidence->absent.size() != n) {
    evidence->absent.assign(n, 0);
    evidence->back_for.assign(n, kSettledAfter);
  }
  for (std::size_t i = 0; i < n; ++i) {
    if (!usable[i]) {
      ++evidence->absent[i];
      continue;
    }
    ++evidence->back_for[i];
    if (evidence->absent[i] >= kLongAway) evidence->back_for[i] = 0;
    evidence->absent[i] = 0;
  }
  const auto unsettled = [](int frames) { return frames < kSettledAfter; };
  if (std::none_of(evidence->back_for.begin(), evidence->back_for.end(), unsettled)) return;
  for (std::size_t e = 0; e < t.edges.size(); ++e)
    for (const Index i : t.edges[e])
      if (unsettled(evidence->back_for[i])) jumps->witness[e] = 0;
}

std::vector<PartingEdge> UpdateEvidence(const DisplacementJumps& jumps, const Pixels& current,
                                        CutEvidence* evidence) {
  const FeatureTriangulation& t = evidence->triangulation;
  const Index edges = static_cast<Index>(t.edges.size());
  const double motion = std::max(jumps.motion_mm, kLeastMotion_mm);
  if (evidence->last_mm.size() != edges) evidence->last_mm = Eigen::VectorXd::Zero(edges);
  Eigen::VectorXd proportion(edges);
  std::vector<int> seen(t.rest.rows(), 0), parted(t.rest.rows(), 0);
  std::vector<PartingEdge> candidates;
  for (Index begin = 0; begin < edges; begin += kTogether) {
    const Index n = std::min(kTogether, edges - begin);
    using Some = Eigen::Array<double, Eigen::Dynamic, 1, 0, kTogether, 1>;
    const auto magnitude = jumps.magnitude_mm.segment(begin, n).array();
    // The error of extrapolating a fit grows with the distance.
    const Some spacings = (t.length_mm.segment(begin, n).array() / t.spacing_mm).max(1.0);
    const Some excess = magnitude - kMargin * evidence->learned.segment(begin, n).array() * motion;
    const Some beyond = excess - (kNoiseFactor * jumps.noise_mm * spacings).max(kLeastExcess_mm);
    // Beyond what noise alone makes of each pair.
    proportion.segment(begin, n) =
        (magnitude - kNoiseJump * jumps.noise_mm * spacings).max(0.0) / motion;
    for (Index i = 0; i < n; ++i) {
      const Index e = begin + i;
      const bool exceeds = beyond[i] > 0.0;
      bool parts = false, closes = false;
      if (magnitude[i] < 0.0) {  // not seen: no evidence, neither way
        proportion[e] = 0.0;
      } else {
        evidence->last_mm[e] = magnitude[i];
        if (jumps.witness[e]) {
          const auto [l, m] = t.edges[e];
          for (Index k : {l, m}) {
            ++seen[k];
            parted[k] += exceeds;
          }
          if (exceeds) {
            const Vec2 now = (current.row(m) - current.row(l)).transpose();
            parts = now.dot(jumps.Jump_mm(t, e)) > 0.0;
            closes = !parts;
          }
        }
        if (exceeds && !closes) proportion[e] = 0.0;
      }
      if (parts)
        candidates.push_back({e, magnitude[i], excess[i]});
      else
        evidence->streak[e] = 0;
    }
  }
  // A feature that parts from nearly all of its neighbours is a wrong track, not tissue beside a
  // cut.
  const auto solitary = [&](Index i) { return parted[i] >= 3 && parted[i] > kSolitary * seen[i]; };
  std::vector<PartingEdge> parting;
  for (const PartingEdge& candidate : candidates) {
    const auto [l, m] = t.edges[candidate.edge];
    int& streak = evidence->streak[candidate.edge];
    streak = solitary(l) || solitary(m) ? 0 : streak + 1;
    if (streak >= kStreak) parting.push_back(candidate);
  }
  evidence->recent.push_back(std::move(proportion));
  if (evidence->recent.size() > kMemory) {
    evidence->learned = evidence->learned.cwiseMax(evidence->recent.front());
    evidence->recent.pop_front();
  }
  return parting;
}

std::vector<PartingEdge> WithoutRefused(std::vector<PartingEdge> parting,
                                        const CutEvidence& evidence) {
  if (evidence.refused_mm.size() == 0) return parting;
  const auto refused = [&](const PartingEdge& p) {
    const double before = evidence.refused_mm[p.edge];
    return before > 0.0 && p.jump_mm < kRefusedFactor * before + kRefusedMore_mm;
  };
  parting.erase(std::remove_if(parting.begin(), parting.end(), refused), parting.end());
  return parting;
}

std::vector<std::vector<Index>> GroupParting(const std::vector<PartingEdge>& parting,
                                             const FeatureTriangulation& t) {
  const Index n = static_cast<Index>(parting.size());
  std::vector<Index> parent(n);
  std::iota(parent.begin(), parent.end(), 0);
  const auto find = [&](Index i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  const auto middle = [&](Index i) -> Vec2 {
    const auto [l, m] = t.edges[parting[i].edge];
    return 0.5 * (t.rest.row(l) + t.rest.row(m)).transpose();
  };
  for (Index i = 0; i < n; ++i)
    for (Index j = i + 1; j < n; ++j)
      if ((middle(i) - middle(j)).norm() < 2.0 * t.spacing_mm) {
        const Index a = find(i), b = find(j);
        parent[std::max(a, b)] = std::min(a, b);
      }
  std::vector<std::vector<Index>> groups(n);
  for (Index i = 0; i < n; ++i) groups[find(i)].push_back(i);
  groups.erase(
      std::remove_if(groups.begin(), groups.end(), [](const auto& group) { return group.empty(); }),
      groups.end());
  const auto total = [&](const std::vector<Index>& group) {
    double sum = 0.0;
    for (Index i : group) sum += parting[i].excess_mm;
    return sum;
  };
  std::stable_sort(groups.begin(), groups.end(),
                   [&](const auto& a, const auto& b) { return total(a) > total(b); });
  return groups;
}

}  // namespace kerf
