#pragma once

// Private to the files that run CGAL's mesher: includes it. Never include this in a public header.
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Mesh_complex_3_in_triangulation_3.h>
#include <CGAL/Mesh_criteria_3.h>
#include <CGAL/Mesh_triangulation_3.h>
#include <CGAL/perturb_mesh_3.h>
#include <CGAL/refine_mesh_3.h>

#include <unordered_map>
#include <vector>

#include "Core/TetMesh.h"
#include "Meshing/DomainMesher.h"

namespace kerf {

/// Cells of the complex as a tetra mesh. @param region_of subdomain index → label
template <typename C3t3, typename RegionOf>
TetMesh ToTetMesh(const C3t3& complex, RegionOf region_of) {
  // Numbers in order of first use: the container's order is that of insertion, hence the same on
  // every run.
  std::unordered_map<const void*, Index> number;
  std::vector<Vec3> vertices;
  std::vector<std::array<Index, 4>> tets;
  TetMesh mesh;
  for (auto cell = complex.cells_in_complex_begin(); cell != complex.cells_in_complex_end();
       ++cell) {
    std::array<Index, 4> tet;
    for (int k = 0; k < 4; ++k) {
      const auto vertex = cell->vertex(k);
      const auto [it, fresh] = number.insert({&*vertex, static_cast<Index>(vertices.size())});
      if (fresh) {
        const auto& p = vertex->point();
        vertices.push_back(
            {CGAL::to_double(p.x()), CGAL::to_double(p.y()), CGAL::to_double(p.z())});
      }
      tet[k] = it->second;
    }
    tets.push_back(tet);
    mesh.region.push_back(static_cast<std::uint8_t>(region_of(complex.subdomain_index(cell))));
  }
  mesh.rest.resize(vertices.size(), 3);
  for (std::size_t i = 0; i < vertices.size(); ++i) mesh.rest.row(i) = vertices[i].transpose();
  mesh.tets.resize(tets.size(), 4);
  for (std::size_t t = 0; t < tets.size(); ++t)
    for (int k = 0; k < 4; ++k) mesh.tets(t, k) = tets[t][k];
  return mesh;
}

}  // namespace kerf
