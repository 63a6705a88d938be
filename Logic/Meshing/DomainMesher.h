#pragma once

#include "Core/Progress.h"
#include "Core/TetMesh.h"

namespace kerf {

/// One run of the Delaunay mesher over a domain.
struct MesherRun {
  double edge_mm = 5.0;    ///< bound of the circumradius of cells and facets
  double offset_mm = 0.0;  ///< the boundary is moved outwards by this (where the domain can)
  bool improve = false;    ///< slivers perturbed; otherwise refinement alone, which is quick and
                           ///< settles the count
  double sliver_bound_deg = 12.0;
};

/// A domain that can be meshed again and again with other parameters (private to Meshing).
/// Deterministic.
class DomainMesher {
 public:
  virtual ~DomainMesher() = default;
  virtual TetMesh Mesh(const MesherRun& run, Progress& progress) const = 0;
  virtual double Volume_mm3() const = 0;  ///< what the mesh should enclose
  virtual bool HasOffset() const { return true; }
};

struct MeshingOptions;
struct MeshingReport;

/// Finds the cell size that meets options.tetrahedra, meshes, and retries with other sizes until
/// the boundary is manifold and the dihedral angles suffice; keeps the best where they do not.
/// @param where file or label source, for messages. @throws InputError when no attempt gives a
/// usable mesh
TetMesh MeshToCount(const DomainMesher& domain, const std::string& where,
                    const MeshingOptions& options, Progress& progress, MeshingReport* report);

/// Largest face-connected component alone, vertices compacted; a warning says what was dropped.
TetMesh LargestComponent(const TetMesh& mesh, const std::string& where, Progress& progress);

}  // namespace kerf
