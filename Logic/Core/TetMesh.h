#pragma once

#include <string>
#include <vector>

#include "Core/SurfaceMesh.h"
#include "Core/Types.h"

namespace kerf {

/// Tetrahedral organ mesh (P_V⁰, C_V): rest vertices and positive tetrahedra with a region label
/// each.
struct TetMesh {
  Points rest;                       ///< N×3, LPS, mm
  Tets tets;                         ///< T×4, positive orientation
  std::vector<std::uint8_t> region;  ///< T labels (Label values)

  Index VertexCount() const { return static_cast<Index>(rest.rows()); }
  Index TetCount() const { return static_cast<Index>(tets.rows()); }
  /// @throws InputError naming `file` and the tetrahedron: index out of range, not positive, region
  /// count wrong
  void Validate(const std::string& file) const;
};

/// Quality of a tetra mesh, at rest or as deformed.
struct MeshQuality {
  Index vertices = 0, tets = 0;
  int components = 0;  ///< face-connected
  double volume_mm3 = 0.0;
  double smallest_dihedral_deg = 0.0;
  double smallest_tet_volume_mm3 = 0.0;
  Index inverted = 0;  ///< tetrahedra with volume ≤ 0
  Index orphans = 0;   ///< vertices without a tetrahedron
  bool manifold_boundary =
      false;  ///< boundary closed and 2-manifold (edges and vertices) on each component
};

double TetVolume(const Points& positions, const Tets& tets, Index tet);
/// Smallest of the six dihedral angles, degrees; negative volume gives a negative value.
double SmallestDihedral_deg(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);
MeshQuality MeasureQuality(const TetMesh& mesh, const Points& positions);

/// Boundary triangles, oriented outwards, in vertex indices of the mesh. `tet_of_face`: the
/// tetrahedron behind each.
Triangles BoundaryFaces(const Tets& tets, std::vector<Index>* tet_of_face = nullptr);
/// Boundary as a surface of its own (points compacted). `vertex_of_point`: mesh vertex of each
/// surface point.
SurfaceMesh BoundarySurface(const TetMesh& mesh, const Points& positions,
                            std::vector<Index>* vertex_of_point = nullptr);
/// Face-connected component of each tetrahedron; returns their count.
int TetComponents(const Tets& tets, std::vector<Index>* component_of_tet);

}  // namespace kerf
