#pragma once

#include <array>
#include <string>
#include <vector>

#include "Core/Embedding.h"
#include "Core/TetMesh.h"

namespace kerf {

/// Separation surface S at rest (extruded cut polygon), or an increment of it.
struct CutSurface {
  Points points;        ///< N×3, LPS, mm, at rest
  Triangles triangles;  ///< F×3, orientation defines the + side
};

/// Ordered cut points p_C on the rest surface.
struct CutPolyline {
  Points points;  ///< N×3, LPS, mm, at rest
};

/// A face that a cut opened: corners k of both sides coincide at rest (corners on the crack front
/// are shared).
struct OpenedFace {
  std::array<Index, 3> a, b;     ///< corners on either side, vertices of the new mesh
  Index tet_a = -1, tet_b = -1;  ///< the tetrahedra behind them, in the new mesh
};

/// What a cut did to a tetra mesh, with the provenance of every vertex and tetrahedron. Features,
/// structures, velocities and the solver are updated from this, never by searching the whole mesh
/// again.
struct TopologyChange {
  TetMesh mesh;  ///< the new mesh
  std::vector<std::array<Index, 4>>
      vertex_parents;             ///< new vertex → 4 old vertices (repeated where fewer)
  Weights4 vertex_weights;        ///< rest_new = Σ w · rest_old(parents) to 1e-9 mm
  std::vector<Index> parent_tet;  ///< new tet → old tet (the one holding its centroid)
  std::vector<Index> kept_tet;  ///< old tet → new tet with the same material, or −1 where changed
  std::vector<Index> new_tets;     ///< new tets that have no identical old one (the patch)
  std::vector<OpenedFace> opened;  ///< new separation faces
  bool changed = false;            ///< false: nothing was cut, `mesh` equals the old one

  /// A per-vertex field (positions, velocities) carried over. @param old_field N_old×3
  Points MapVertexField(const Points& old_field) const;
  /// An embedding carried over: the same material points (1e-9 mm) in the new mesh. Only `new_tets`
  /// are searched, only for points whose tet changed; where several hold a point, it stays on the
  /// side of an earlier cut that it was on. @param old_mesh the mesh before
  Embedding MapEmbedding(const Embedding& old, const TetMesh& old_mesh) const;
};

}  // namespace kerf
