#include "Geometry/Delaunay.h"

#include <CGAL/Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>

#include <algorithm>

namespace kerf {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using VertexBase = CGAL::Triangulation_vertex_base_with_info_2<Index, Kernel>;
using Structure = CGAL::Triangulation_data_structure_2<VertexBase>;
using Triangulation = CGAL::Delaunay_triangulation_2<Kernel, Structure>;

}  // namespace

std::vector<std::array<Index, 3>> DelaunayTriangles(const Pixels& points) {
  Triangulation triangulation;
  for (Index i = 0; i < points.rows(); ++i) {
    const std::size_t before = triangulation.number_of_vertices();
    const auto vertex = triangulation.insert({points(i, 0), points(i, 1)});
    if (triangulation.number_of_vertices() > before) vertex->info() = i;
  }
  std::vector<std::array<Index, 3>> triangles;
  for (auto face = triangulation.finite_faces_begin(); face != triangulation.finite_faces_end();
       ++face) {
    std::array<Index, 3> t{face->vertex(0)->info(), face->vertex(1)->info(),
                           face->vertex(2)->info()};
    std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
    triangles.push_back(t);
  }
  std::sort(triangles.begin(), triangles.end());
  return triangles;
}

}  // namespace kerf
