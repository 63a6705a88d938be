#include "Evaluation/CutComparison.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kerf {
namespace {

constexpr double kStep_mm = 0.5;
constexpr double kFarthestMatch_mm = 15.0;
constexpr double kEarliest_s = 0.2;

Points Densified(const Points& line) {
  if (line.rows() < 2) return line;
  std::vector<Vec3> dense;
  for (Index i = 0; i + 1 < line.rows(); ++i) {
    const Vec3 a = line.row(i).transpose(), b = line.row(i + 1).transpose();
    const int pieces = std::max(1, static_cast<int>(std::ceil((b - a).norm() / kStep_mm)));
    for (int k = 0; k < pieces; ++k) dense.push_back(a + (b - a) * (double(k) / pieces));
  }
  dense.push_back(line.row(line.rows() - 1).transpose());
  Points out(static_cast<Index>(dense.size()), 3);
  for (std::size_t i = 0; i < dense.size(); ++i) out.row(i) = dense[i].transpose();
  return out;
}

std::vector<double> NearestDistances(const Points& from, const Points& to) {
  std::vector<double> distances;
  for (Index i = 0; i < from.rows(); ++i)
    distances.push_back((to.rowwise() - from.row(i)).rowwise().norm().minCoeff());
  return distances;
}

double Median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  return n % 2 ? values[n / 2] : 0.5 * (values[n / 2 - 1] + values[n / 2]);
}

struct Pair {
  int detected, truth;
  LineDistance distance;
};

}  // namespace

LineDistance CompareLines(const Points& detected, const Points& truth) {
  const Points a = Densified(detected), b = Densified(truth);
  const auto forward = NearestDistances(a, b), backward = NearestDistances(b, a);
  LineDistance out;
  for (double d : forward) out.mean_mm += d;
  for (double d : backward) out.mean_mm += d;
  out.mean_mm /= static_cast<double>(forward.size() + backward.size());
  out.detected_to_true_max_mm = *std::max_element(forward.begin(), forward.end());
  out.true_to_detected_max_mm = *std::max_element(backward.begin(), backward.end());
  out.hausdorff_mm = std::max(out.detected_to_true_max_mm, out.true_to_detected_max_mm);
  out.detected_to_true_median_mm = Median(forward);
  return out;
}

CutComparison CompareCuts(const std::vector<DetectedCut>& detected,
                          const std::vector<TrueCut>& truth, double frames_per_second) {
  std::vector<Pair> pairs;
  for (int i = 0; i < static_cast<int>(detected.size()); ++i)
    for (int j = 0; j < static_cast<int>(truth.size()); ++j)
      if (detected[i].polyline_rest.rows() > 0 && truth[j].polyline_rest.rows() > 0)
        pairs.push_back({i, j, CompareLines(detected[i].polyline_rest, truth[j].polyline_rest)});
  std::stable_sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) {
    return a.distance.detected_to_true_median_mm < b.distance.detected_to_true_median_mm;
  });

  CutComparison result;
  result.detected = static_cast<int>(detected.size());
  result.truth = static_cast<int>(truth.size());
  std::vector<char> detected_used(detected.size(), 0), truth_used(truth.size(), 0);
  for (const auto& [i, j, distance] : pairs) {
    if (detected_used[i] || truth_used[j]) continue;
    if (distance.detected_to_true_median_mm > kFarthestMatch_mm) continue;
    const double frame =
        detected[i].detected_frame.value_or(std::numeric_limits<double>::infinity());
    if (frame < truth[j].start_frame - kEarliest_s * frames_per_second) continue;
    detected_used[i] = truth_used[j] = 1;
    CutMatch match{i, j, distance, truth[j].start_time_s, {}, {}};
    if (detected[i].detected_frame) {
      match.timing_error_s = frame / frames_per_second - truth[j].start_time_s;
      if (truth[j].first_frame_opening_over_1mm)
        match.delay_after_1mm_opening_s =
            (frame - *truth[j].first_frame_opening_over_1mm) / frames_per_second;
    }
    result.matched.push_back(match);
  }
  result.missed = result.truth - static_cast<int>(result.matched.size());
  result.false_cuts = result.detected - static_cast<int>(result.matched.size());
  return result;
}

}  // namespace kerf
