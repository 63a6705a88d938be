#include "Registration/DisplacementJump.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "Geometry/Delaunay.h"

namespace kerf {
namespace {

using Mat2 = Eigen::Matrix2d;

constexpr int kNear = 12;   // neighbours that a local fit uses
constexpr int kKnown = 40;  // neighbours that are kept, for when nearer ones are lost
static_assert(kKnown <= 64, "FeatureTriangulation::between has a bit for each");
constexpr double kFitScale_mm = 0.3;  // residual beyond which a neighbour belongs to another side
constexpr double kSliver_mm2 = 2.0;   // twice the area below which a triangle tells nothing
constexpr double kLongest = 6.0;      // times the median: pairs across gaps of the feature cloud

double Median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + values.size() / 2;
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Depth per lateral mm of the surface at each feature, from a plane through its neighbours.
std::vector<double> Steepness(const Points& rest, const std::vector<std::vector<Index>>& near) {
  std::vector<double> steep(rest.rows(), 0.0);
  for (Index l = 0; l < rest.rows(); ++l) {
    Mat2 a = 1e-6 * Mat2::Identity();
    Vec2 b = Vec2::Zero();
    for (std::size_t k = 0; k < std::min<std::size_t>(kNear, near[l].size()); ++k) {
      const Index m = near[l][k];
      const Vec2 d = (rest.row(m) - rest.row(l)).head<2>().transpose();
      a += d * d.transpose();
      b += d * (rest(m, 2) - rest(l, 2));
    }
    steep[l] = (a.inverse() * b).norm();
  }
  return steep;
}

/// Robust displacement gradient at feature l: the candidate (one per triangle of its fan, and the
/// common fit) that most neighbours agree with, then refined by reweighting.
Mat2 LocalGradient(const FeatureTriangulation& t, const Pixels& displacement,
                   const std::vector<char>& usable, Index l) {
  // Places and motions of the neighbours from here; those that are missing weigh nothing.
  using Values = Eigen::Array<double, kNear, 1>;
  Values x = Values::Zero(), y = x, u = x, v = x, prior = x;
  int n = 0;
  for (Index m : t.near[l]) {
    if (n == kNear) break;
    if (!usable[m]) continue;
    x[n] = t.rest(m, 0) - t.rest(l, 0);
    y[n] = t.rest(m, 1) - t.rest(l, 1);
    u[n] = displacement(m, 0) - displacement(l, 0);
    v[n] = displacement(m, 1) - displacement(l, 1);
    ++n;
  }
  if (n < 4) return Mat2::Zero();
  const Values square = x.square() + y.square();
  const double mean_square = square.sum() / n;
  prior.head(n) = 1.0 / (1.0 + square.head(n) / mean_square);
  const double s2 = kFitScale_mm * kFitScale_mm;
  const auto fit = [&](const Values& w) {
    const Values wx = w * x, wy = w * y;
    Mat2 a, b;
    a << (wx * x).sum() + 1e-3, (wx * y).sum(), (wx * y).sum(), (wy * y).sum() + 1e-3;
    b << (wx * u).sum(), (wy * u).sum(), (wx * v).sum(), (wy * v).sum();
    return Mat2(b * a.inverse());
  };
  const auto misfit2 = [&](const Mat2& g) {
    return Values((u - g(0, 0) * x - g(0, 1) * y).square() +
                  (v - g(1, 0) * x - g(1, 1) * y).square());
  };
  const auto cost = [&](const Mat2& g) {
    const Values r2 = misfit2(g);
    return (prior * r2 / (r2 + s2)).sum();
  };
  Mat2 best = fit(prior);
  double best_cost = cost(best);
  for (const auto& [a, b, from_sides] : t.fans[l]) {
    if (!usable[a] || !usable[b]) continue;
    Mat2 motion;
    motion << (displacement.row(a) - displacement.row(l)).transpose(),
        (displacement.row(b) - displacement.row(l)).transpose();
    const Mat2 g = motion * from_sides;
    const double c = cost(g);
    if (c < best_cost) {
      best_cost = c;
      best = g;
    }
  }
  for (int iteration = 0; iteration < 3; ++iteration)
    best = fit(prior / (1.0 + misfit2(best) / s2).square());
  return best;
}

}  // namespace

FeatureTriangulation TriangulateFeatures(const Points& rest_camera, const std::vector<char>& usable,
                                         double steepest) {
  FeatureTriangulation t;
  const Index n = static_cast<Index>(rest_camera.rows());
  t.rest = rest_camera.leftCols<2>();
  t.near.resize(n);
  t.fans.resize(n);
  std::vector<Index> members;
  for (Index i = 0; i < n; ++i)
    if (usable[i]) members.push_back(i);
  if (members.size() < 8) return t;
  Pixels chosen(members.size(), 2);
  for (std::size_t i = 0; i < members.size(); ++i) chosen.row(i) = t.rest.row(members[i]);

  const auto triangles = DelaunayTriangles(chosen);
  std::vector<std::array<Index, 2>> all;
  for (const auto& triangle : triangles)
    for (int k = 0; k < 3; ++k) {
      const Index a = members[triangle[k]], b = members[triangle[(k + 1) % 3]];
      all.push_back({std::min(a, b), std::max(a, b)});
    }
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  std::vector<double> lengths;
  for (const auto& e : all) lengths.push_back((t.rest.row(e[0]) - t.rest.row(e[1])).norm());
  t.spacing_mm = Median(lengths);

  for (Index l : members) {
    std::vector<std::pair<double, Index>> order;
    for (Index m : members)
      if (m != l) order.push_back({(t.rest.row(m) - t.rest.row(l)).squaredNorm(), m});
    const std::size_t count = std::min<std::size_t>(kKnown, order.size());
    std::partial_sort(order.begin(), order.begin() + count, order.end());
    for (std::size_t k = 0; k < count; ++k) t.near[l].push_back(order[k].second);
  }
  const std::vector<double> steep = Steepness(rest_camera, t.near);
  for (const auto& triangle : triangles) {
    std::array<Index, 3> corner;
    double longest = 0.0;
    for (int k = 0; k < 3; ++k) corner[k] = members[triangle[k]];
    for (int k = 0; k < 3; ++k)
      longest = std::max(longest, (t.rest.row(corner[k]) - t.rest.row(corner[(k + 1) % 3])).norm());
    if (longest > 3.0 * t.spacing_mm) continue;
    for (int k = 0; k < 3; ++k) {
      const Index l = corner[k], a = corner[(k + 1) % 3], b = corner[(k + 2) % 3];
      Mat2 sides;
      sides << (t.rest.row(a) - t.rest.row(l)).transpose(),
          (t.rest.row(b) - t.rest.row(l)).transpose();
      if (std::abs(sides.determinant()) < kSliver_mm2) continue;
      t.fans[l].push_back({a, b, sides.inverse()});
    }
  }
  // Witnesses are pairs, not only Delaunay edges: where features beside a cut are lost, the ones
  // behind them still see it.
  std::vector<std::array<Index, 2>> pairs;
  for (Index l : members)
    for (Index m : t.near[l]) pairs.push_back({std::min(l, m), std::max(l, m)});
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  std::vector<double> kept_length;
  for (const auto& [l, m] : pairs) {
    const double length = (t.rest.row(l) - t.rest.row(m)).norm();
    if (length > kLongest * t.spacing_mm || std::max(steep[l], steep[m]) > steepest) continue;
    t.edges.push_back({l, m});
    kept_length.push_back(length);
    std::uint64_t inside = 0;
    for (std::size_t k = 0; k < t.near[l].size(); ++k) {
      const Index i = t.near[l][k];
      const Vec2 a = (t.rest.row(l) - t.rest.row(i)).transpose();
      const Vec2 b = (t.rest.row(m) - t.rest.row(i)).transpose();
      if (i != m && a.dot(b) < 0.0) inside |= std::uint64_t{1} << k;
    }
    t.between.push_back(inside);
  }
  t.length_mm = Eigen::Map<Eigen::VectorXd>(kept_length.data(), kept_length.size());
  return t;
}

DisplacementJumps MeasureJumps(const FeatureTriangulation& t, const Pixels& current,
                               const std::vector<char>& usable) {
  const Index n = static_cast<Index>(t.rest.rows()), edges = static_cast<Index>(t.edges.size());
  DisplacementJumps out;
  out.displacement_mm = current - t.rest;
  out.gradient.assign(n, Mat2::Zero());
  std::vector<std::uint64_t> seen(n, 0);  // of near[l], as in `between`
  tbb::parallel_for(tbb::blocked_range<Index>(0, n, 32), [&](const auto& range) {
    for (Index l = range.begin(); l < range.end(); ++l) {
      if (!usable[l] || t.near[l].empty()) continue;
      out.gradient[l] = LocalGradient(t, out.displacement_mm, usable, l);
      for (std::size_t k = 0; k < t.near[l].size(); ++k)
        seen[l] |= std::uint64_t(usable[t.near[l][k]] != 0) << k;
    }
  });
  out.magnitude_mm.resize(edges);
  out.witness.resize(edges);
  tbb::parallel_for(tbb::blocked_range<Index>(0, edges, 1024), [&](const auto& range) {
    for (Index e = range.begin(); e < range.end(); ++e) {
      const auto [l, m] = t.edges[e];
      const bool measured = usable[l] && usable[m];
      out.magnitude_mm[e] = measured ? out.Jump_mm(t, e).norm() : -1.0;
      out.witness[e] = measured && (t.between[e] & seen[l]) == 0;
    }
  });
  std::vector<double> magnitudes, motions;
  for (Index e = 0; e < edges; ++e) {
    if (!out.witness[e]) continue;
    magnitudes.push_back(out.magnitude_mm[e] / std::max(1.0, t.length_mm[e] / t.spacing_mm));
    motions.push_back(out.Smooth_mm(t, e).norm());
  }
  out.noise_mm = 1.4826 * Median(std::move(magnitudes));
  out.motion_mm = Median(std::move(motions));
  return out;
}

}  // namespace kerf
