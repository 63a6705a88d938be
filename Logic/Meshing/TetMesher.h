#pragma once

#include "Core/Progress.h"
#include "Core/SurfaceMesh.h"
#include "Core/TetMesh.h"
#include "Core/Volume.h"

namespace kerf {

struct MeshingOptions {
  int tetrahedra = 15000;         ///< wanted; reached within about 15 %
  double min_dihedral_deg = 8.0;  ///< perturbed until reached where possible; reported otherwise
};

struct MeshingReport {
  MeshQuality quality;
  double input_volume_mm3 = 0.0;  ///< of the voxels or of the closed surface
  double volume_error = 0.0;      ///< relative
  double edge_mm = 0.0;           ///< cell size that met the wanted count
};

/// Tetra mesh of a label map that is already smooth (Adapters/Vtk smooths: PLATFORM notes in
/// docs/decisions): labels Organ, Tumour and Internal are filled as one organ without cavities;
/// Tumour is a sub-domain (region = Label::Tumour), the rest is Label::Organ. Deterministic.
/// @throws InputError on empty labels; Cancelled
TetMesh MeshLabelMap(const LabelMap& labels, const MeshingOptions& options, Progress& progress,
                     MeshingReport* report = nullptr);

/// Tetra mesh of a closed surface (LPS mm). An inverted surface, holes and self-intersections are
/// refused.
/// @throws InputError naming `file`
TetMesh MeshClosedSurface(const SurfaceMesh& surface, const std::string& file,
                          const MeshingOptions& options, Progress& progress,
                          MeshingReport* report = nullptr);

}  // namespace kerf
