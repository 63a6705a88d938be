#include "Registration/Targets.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace kerf {
namespace {

SurfaceMesh PositionedBoundary(const TetMesh& mesh, const Points& positions,
                               std::vector<Index>* vertex_of_point,
                               std::vector<Index>* tet_of_triangle) {
  // BoundarySurface keeps the triangle order of BoundaryFaces.
  BoundaryFaces(mesh.tets, tet_of_triangle);
  return BoundarySurface(mesh, positions, vertex_of_point);
}

/// Nearest surface point to a ray that misses: walk along the ray around the organ's depth.
SurfaceHit NearestToRay(const SurfaceTree& tree, const Ray& ray, const Vec3& middle,
                        double half_extent) {
  SurfaceHit best;
  best.distance_mm = 1e30;
  const double along = ray.direction.dot(middle - ray.origin);
  constexpr int kSteps = 64;
  double at = along;
  for (int i = 0; i <= kSteps; ++i) {
    const double s = along + half_extent * (2.0 * i / kSteps - 1.0);
    const SurfaceHit hit = tree.Closest(ray.origin + s * ray.direction);
    if (hit.distance_mm < best.distance_mm) {
      best = hit;
      at = s;
    }
  }
  for (int i = 0; i < 10; ++i) {  // slide to the foot of the closest point
    at = ray.direction.dot(best.point - ray.origin);
    const SurfaceHit hit = tree.Closest(ray.origin + at * ray.direction);
    if (hit.distance_mm >= best.distance_mm) break;
    best = hit;
  }
  return best;
}

}  // namespace

BindingSurface::BindingSurface(const TetMesh& mesh, const Points& positions)
    : mesh_(mesh),
      surface_(PositionedBoundary(mesh, positions, &vertex_of_point_, &tet_of_triangle_)),
      tree_(surface_) {}

BoundFeatures BindingSurface::Bind(const Pixels& pixels, const CameraModel& camera,
                                   double reach_mm) const {
  const Index n = static_cast<Index>(pixels.rows());
  BoundFeatures bound;
  bound.embedding.tet.resize(n);
  bound.embedding.weights = Weights4::Zero(n, 4);
  bound.rest.resize(n, 3);
  bound.rest_depth_mm.resize(n);
  bound.on_surface.assign(n, 1);
  const Vec3 low = surface_.points.colwise().minCoeff().transpose();
  const Vec3 high = surface_.points.colwise().maxCoeff().transpose();
  for (Index i = 0; i < n; ++i) {
    const Ray ray = camera.RayThrough(pixels.row(i).transpose());
    auto hit = tree_.FirstHit(ray);
    if (!hit) {
      hit = NearestToRay(tree_, ray, 0.5 * (low + high), 0.5 * (high - low).norm());
      bound.on_surface[i] = hit->distance_mm <= reach_mm;
    }
    const Index tet = tet_of_triangle_[hit->triangle];
    bound.embedding.tet[i] = tet;
    for (int k = 0; k < 3; ++k) {
      const Index vertex = vertex_of_point_[surface_.triangles(hit->triangle, k)];
      for (int c = 0; c < 4; ++c)
        if (mesh_.tets(tet, c) == vertex) bound.embedding.weights(i, c) += hit->weights[k];
    }
    bound.rest_depth_mm[i] = camera.Depth(hit->point);
  }
  bound.rest = bound.embedding.Positions(mesh_.rest, mesh_.tets);
  return bound;
}

Points TargetsAtRestDepth(const Pixels& pixels, const Eigen::VectorXd& rest_depth_mm,
                          const CameraModel& camera) {
  Points targets(pixels.rows(), 3);
  for (Index i = 0; i < pixels.rows(); ++i)
    targets.row(i) = camera.PointAtDepth(pixels.row(i).transpose(), rest_depth_mm[i]).transpose();
  return targets;
}

}  // namespace kerf
