#include "Geometry/SurfaceTree.h"

#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <algorithm>
#include <array>
#include <stdexcept>
#include <vector>

namespace kerf {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using Triangle = Kernel::Triangle_3;
using Primitive = CGAL::AABB_triangle_primitive<Kernel, std::vector<Triangle>::const_iterator>;
using Tree = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, Primitive>>;

Point ToPoint(const Vec3& p) { return {p[0], p[1], p[2]}; }
Vec3 FromPoint(const Point& p) { return {p.x(), p.y(), p.z()}; }
Kernel::Ray_3 ToRay(const Ray& ray) {
  return {ToPoint(ray.origin),
          Kernel::Vector_3(ray.direction[0], ray.direction[1], ray.direction[2])};
}

/// Barycentric weights of p, a point of the triangle's plane.
Vec3 TriangleWeights(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 u = b - a, v = c - a, w = p - a;
  const double uu = u.dot(u), uv = u.dot(v), vv = v.dot(v), wu = w.dot(u), wv = w.dot(v);
  const double determinant = uu * vv - uv * uv;
  const double s = (vv * wu - uv * wv) / determinant, t = (uu * wv - uv * wu) / determinant;
  return {1.0 - s - t, s, t};
}

/// Weights of a point that is known to lie on the triangle: rounding must not put it beside.
Vec3 ClampedWeights(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 w = TriangleWeights(p, a, b, c).cwiseMax(0.0);
  return w / w.sum();
}

}  // namespace

struct SurfaceTree::Impl {
  std::vector<Triangle> triangles;
  std::vector<Index> triangle_index;  ///< degenerate triangles are left out of the tree
  Tree tree;

  SurfaceHit HitAt(std::size_t position, const Vec3& p) const {
    const Triangle& t = triangles[position];
    const Vec3 a = FromPoint(t[0]), b = FromPoint(t[1]), c = FromPoint(t[2]);
    SurfaceHit hit;
    hit.triangle = triangle_index[position];
    hit.weights = ClampedWeights(p, a, b, c);
    hit.point = hit.weights[0] * a + hit.weights[1] * b + hit.weights[2] * c;
    return hit;
  }
  std::size_t PositionOf(Tree::Primitive_id id) const { return id - triangles.cbegin(); }
};

SurfaceTree::SurfaceTree(const SurfaceMesh& surface) : impl_(std::make_unique<Impl>()) {
  impl_->triangles.reserve(surface.triangles.rows());
  for (Index t = 0; t < surface.triangles.rows(); ++t) {
    std::array<Point, 3> corner;
    for (int k = 0; k < 3; ++k)
      corner[k] = ToPoint(surface.points.row(surface.triangles(t, k)).transpose());
    if (CGAL::collinear(corner[0], corner[1], corner[2])) continue;
    impl_->triangles.emplace_back(corner[0], corner[1], corner[2]);
    impl_->triangle_index.push_back(t);
  }
  // Built here, not at the first query: queries must be safe from several threads.
  impl_->tree.insert(impl_->triangles.cbegin(), impl_->triangles.cend());
  impl_->tree.build();
  if (!impl_->triangles.empty()) impl_->tree.accelerate_distance_queries();
}

SurfaceTree::~SurfaceTree() = default;
SurfaceTree::SurfaceTree(SurfaceTree&&) noexcept = default;
SurfaceTree& SurfaceTree::operator=(SurfaceTree&&) noexcept = default;

std::optional<SurfaceHit> SurfaceTree::FirstHit(const Ray& ray) const {
  if (impl_->triangles.empty()) return std::nullopt;
  const auto found = impl_->tree.first_intersected_primitive(ToRay(ray));
  if (!found) return std::nullopt;
  const std::size_t position = impl_->PositionOf(*found);
  const Triangle& t = impl_->triangles[position];
  const Vec3 a = FromPoint(t[0]), b = FromPoint(t[1]), c = FromPoint(t[2]);
  const Vec3 normal = (b - a).cross(c - a);
  const double slope = normal.dot(ray.direction);
  // A ray within the triangle's plane meets it first at the corner nearest to the origin.
  double distance = 0.0;
  if (std::abs(slope) > 1e-14 * normal.norm())
    distance = normal.dot(a - ray.origin) / slope;
  else
    distance =
        std::min({(a - ray.origin).norm(), (b - ray.origin).norm(), (c - ray.origin).norm()});
  SurfaceHit hit = impl_->HitAt(position, ray.origin + distance * ray.direction);
  hit.distance_mm = (hit.point - ray.origin).norm();
  return hit;
}

bool SurfaceTree::IsHit(const Ray& ray) const {
  return !impl_->triangles.empty() && impl_->tree.do_intersect(ToRay(ray));
}

SurfaceHit SurfaceTree::Closest(const Vec3& p) const {
  if (impl_->triangles.empty())
    throw std::invalid_argument("SurfaceTree::Closest: the surface has no triangle with an area");
  const auto found = impl_->tree.closest_point_and_primitive(ToPoint(p));
  SurfaceHit hit = impl_->HitAt(impl_->PositionOf(found.second), FromPoint(found.first));
  hit.distance_mm = (hit.point - p).norm();
  return hit;
}

bool SurfaceTree::Inside(const Vec3& p) const {
  if (impl_->triangles.empty() || !CGAL::do_overlap(impl_->tree.bbox(), ToPoint(p).bbox()))
    return false;
  // Each ray counts exactly (exact predicates), but one that passes through an edge counts both its
  // triangles. Generic directions make that improbable; a vote of three makes it harmless.
  const std::array<Kernel::Vector_3, 3> directions{Kernel::Vector_3(0.3571, 0.7919, 0.4955),
                                                   Kernel::Vector_3(-0.8123, 0.1733, 0.5569),
                                                   Kernel::Vector_3(0.2237, -0.5413, -0.8105)};
  int votes = 0;
  for (const auto& direction : directions)
    votes += impl_->tree.number_of_intersected_primitives(Kernel::Ray_3(ToPoint(p), direction)) % 2;
  return votes >= 2;
}

}  // namespace kerf
