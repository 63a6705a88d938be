#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Surface_mesh.h>

#include <algorithm>
#include <array>
#include <tuple>
#include <vector>

#include "Core/Errors.h"
#include "Meshing/Soup.h"
#include "Meshing/SurfaceDomain.h"

namespace kerf {
namespace {

struct HalfEdge {
  Index low, high, triangle;
  bool forward;
  bool operator<(const HalfEdge& o) const {
    return std::tie(low, high, triangle) < std::tie(o.low, o.high, o.triangle);
  }
};

std::string Triangle(Index t) { return "triangle " + std::to_string(t); }

void RequireClosedManifold(const SurfaceMesh& surface, const std::string& file) {
  std::vector<HalfEdge> edges;
  edges.reserve(3 * surface.triangles.rows());
  for (Index t = 0; t < surface.triangles.rows(); ++t)
    for (int k = 0; k < 3; ++k) {
      const Index a = surface.triangles(t, k), b = surface.triangles(t, (k + 1) % 3);
      if (a == b) throw InputError(file, Triangle(t), "has the same corner twice");
      edges.push_back({std::min(a, b), std::max(a, b), t, a < b});
    }
  std::sort(edges.begin(), edges.end());
  for (std::size_t i = 0; i < edges.size();) {
    std::size_t j = i;
    while (j < edges.size() && edges[j].low == edges[i].low && edges[j].high == edges[i].high) ++j;
    const std::string where = Triangle(edges[i].triangle);
    const std::string edge = "its edge between points " + std::to_string(edges[i].low) + " and " +
                             std::to_string(edges[i].high);
    if (j - i == 1)
      throw InputError(file, where, "the surface is not closed: " + edge + " is open");
    if (j - i > 2)
      throw InputError(file, where, edge + " belongs to " + std::to_string(j - i) + " triangles");
    if (edges[i].forward == edges[i + 1].forward)
      throw InputError(file, where, "is oriented against " + Triangle(edges[i + 1].triangle));
    i = j;
  }
}

}  // namespace

void RequireClosedSurface(const SurfaceMesh& surface, const std::string& file) {
  if (surface.Empty()) throw InputError(file, "triangles", "the surface has none");
  surface.Validate(file);
  RequireClosedManifold(surface, file);
  if (surface.SignedVolume() <= 0.0)
    throw InputError(file, "orientation",
                     "the surface is inverted (its triangles are clockwise seen from outside)");

  namespace pmp = CGAL::Polygon_mesh_processing;
  using Mesh = CGAL::Surface_mesh<CGAL::Exact_predicates_inexact_constructions_kernel::Point_3>;
  std::vector<Mesh::Point> points;
  std::vector<std::array<std::size_t, 3>> triangles;
  ToSoup(surface, &points, &triangles);
  if (!pmp::is_polygon_soup_a_polygon_mesh(triangles))
    throw InputError(file, "triangles", "the surface is pinched: a point joins separate fans");
  Mesh mesh;
  pmp::polygon_soup_to_polygon_mesh(points, triangles, mesh);
  std::vector<std::pair<Mesh::Face_index, Mesh::Face_index>> crossing;
  pmp::self_intersections(mesh, std::back_inserter(crossing));
  if (!crossing.empty()) {
    const auto first = *std::min_element(crossing.begin(), crossing.end());
    throw InputError(
        file, Triangle(static_cast<Index>(first.first)),
        "the surface intersects itself: it crosses " + Triangle(static_cast<Index>(first.second)));
  }
}

}  // namespace kerf
