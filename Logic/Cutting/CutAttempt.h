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
/// What a cut of this patch has to keep.
PatchAngles RequiredAngles(const CutPatch& patch, const CutOptions& options);

/// A patch that was cut along one sheet.
struct CutAttempt {
  CutPatch patch;
  SeparationReport separation;
  Index snapped = 0;
  double angle_deg = 0;           ///< smallest at rest among changed tetrahedra
  double angle_current_deg = 90;  ///< as deformed
  bool given_up = false;          ///< no end to the edges that S crosses
};

/// The best of several attempts to cut `start`, whose core is marked, along one sheet. Nothing:
/// refused if `sheet` says so, otherwise there is nothing to separate.
/// @param before the patch as it is in the mesh
/// @param required angles that the result must have
std::optional<CutAttempt> CutAlong(CutSheet* sheet, const CutPatch& before, CutPatch* start,
                                   const CutOptions& options, const PatchAngles& required);

}  // namespace kerf
