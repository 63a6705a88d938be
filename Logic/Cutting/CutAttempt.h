#pragma once

#include <optional>

#include "Cutting/CutPatch.h"
#include "Cutting/CutSheet.h"
#include "Cutting/Separation.h"
#include "Cutting/TetCutter.h"

namespace kerf {

/// Smallest dihedral angles of a patch.
struct PatchAngles {
  double rest_deg, current_deg;
};
/// What a cut of a patch has to keep.
struct CutDemands {
  PatchAngles angles;
  double volume_mm3 = 0;                         ///< of every changed tetrahedron
  std::size_t most_vertices = 0, most_tets = 0;  ///< of the patch
};
/// @param work tetrahedra with something to cut @param mean_mm3 of the mesh's tetrahedra
CutDemands DemandsOn(const CutPatch& patch, Index work, double mean_mm3, const CutOptions& options);

/// A patch that was cut along one sheet.
struct CutAttempt {
  CutPatch patch;
  SeparationReport separation;
  Index snapped = 0;
  double angle_deg = 0;           ///< smallest at rest among changed tetrahedra
  double angle_current_deg = 90;  ///< as deformed
  double smallest_mm3 = 1e300;    ///< volume among changed tetrahedra, at rest
  bool given_up = false;          ///< no end to the edges that S crosses
};

/// The best of several attempts to cut `start`, whose core is marked, along one sheet. Nothing:
/// refused if `sheet` says so, otherwise there is nothing to separate.
/// @param before the patch as it is in the mesh
/// @param demands that the result must meet
std::optional<CutAttempt> CutAlong(CutSheet* sheet, const CutPatch& before, CutPatch* start,
                                   const CutOptions& options, const CutDemands& demands);

}  // namespace kerf
