#include "Evaluation/SurfaceDistance.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "Geometry/SurfaceTree.h"

namespace kerf {
namespace {

Vec3 Corner(const SurfaceMesh& surface, Index triangle, int k) {
  return surface.points.row(surface.triangles(triangle, k)).transpose();
}

}  // namespace

Points SampleSurface(const SurfaceMesh& surface, int samples, RandomGenerator* random) {
  const Index faces = static_cast<Index>(surface.triangles.rows());
  std::vector<double> cumulated(faces);
  double total = 0.0;
  for (Index t = 0; t < faces; ++t) {
    const Vec3 a = Corner(surface, t, 0);
    total += (Corner(surface, t, 1) - a).cross(Corner(surface, t, 2) - a).norm();
    cumulated[t] = total;
  }
  if (!(total > 0.0)) throw std::invalid_argument("SampleSurface: the surface has no area");
  // All draws for the triangles come first, then the two coordinates in them.
  std::vector<Index> triangle(samples);
  for (auto& t : triangle) {
    const auto at = std::upper_bound(cumulated.begin(), cumulated.end(), random->Uniform() * total);
    t = std::min(static_cast<Index>(at - cumulated.begin()), faces - 1);
  }
  std::vector<double> root(samples);
  for (double& r : root) r = std::sqrt(random->Uniform());
  Points points(samples, 3);
  for (int i = 0; i < samples; ++i) {
    const double r = root[i], s = random->Uniform();
    points.row(i) =
        ((1.0 - r) * Corner(surface, triangle[i], 0) +
         r * (1.0 - s) * Corner(surface, triangle[i], 1) + r * s * Corner(surface, triangle[i], 2))
            .transpose();
  }
  return points;
}

std::optional<DistanceStatistics> SampledHausdorff(const SurfaceMesh& a, const SurfaceMesh& b,
                                                   int samples, std::uint32_t seed) {
  if (a.Empty() || b.Empty() || !(a.Area() > 0.0) || !(b.Area() > 0.0)) return std::nullopt;
  RandomGenerator random(seed);
  DistanceStatistics result;
  double sum = 0.0;
  const auto add = [&](const SurfaceMesh& from, const SurfaceMesh& to) {
    const SurfaceTree tree(to);
    const Points points = SampleSurface(from, samples, &random);
    for (Index i = 0; i < points.rows(); ++i) {
      const double distance = tree.Closest(points.row(i).transpose()).distance_mm;
      sum += distance;
      result.max_mm = std::max(result.max_mm, distance);
    }
  };
  add(a, b);
  add(b, a);
  result.mean_mm = sum / (2.0 * samples);
  return result;
}

Points CarriedPoints(const SurfaceMesh& rest, const Points& current, const Points& points) {
  const SurfaceTree tree(rest);
  Points carried(points.rows(), 3);
  for (Index i = 0; i < points.rows(); ++i) {
    const SurfaceHit hit = tree.Closest(points.row(i).transpose());
    carried.row(i) = points.row(i) - hit.point.transpose();
    for (int k = 0; k < 3; ++k)
      carried.row(i) += hit.weights[k] * current.row(rest.triangles(hit.triangle, k));
  }
  return carried;
}

}  // namespace kerf
