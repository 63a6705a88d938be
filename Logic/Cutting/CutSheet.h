#pragma once

#include <array>
#include <utility>
#include <vector>

#include "Cutting/CoreNear.h"
#include "Cutting/CutPatch.h"
#include "Cutting/CutRegion.h"
#include "Cutting/SurfaceIndex.h"

namespace kerf {

/// What hangs together of a separation surface, and what it still has to cut.
struct CutSheet {
  SurfaceIndex index;
  bool fresh;                ///< has triangles that were not there at the last call
  bool meets = false;        ///< comes near the organ
  std::vector<Index> work;   ///< tetrahedra of the mesh with something to cut, ascending
  bool refused = false;      ///< by the last attempt
  std::vector<CutBox> left;  ///< where it stays uncut, at rest
  std::vector<std::pair<Index, SurfaceNear>> known;  ///< vertex of the mesh, ascending: its place

  /// @param part of the sheet near what is new in S
  /// @param region of the mesh in which to look for something to cut
  CutSheet(const CutSurface& part, bool is_fresh, const TetMesh& mesh, const CutBox& region,
           double slack_mm);
  /// Where the core of a patch of the mesh stands to the sheet.
  CoreNear NearOf(const CutPatch& patch) const;
  /// Notes these tetrahedra of the patch as left uncut.
  void Leave(const CutPatch& patch, const std::vector<int>& tets);
};

/// The first of each pair of tetrahedra that still have a face in common.
std::vector<int> StillJoined(const CutPatch& patch, const std::vector<std::array<int, 2>>& pairs);

/// Tetrahedra of the patch, ascending, with an edge that S crosses or a face on S that is not open:
/// where there is something to cut. @param near where all vertices stand to S, may be null
std::vector<int> TetsToWorkOn(const SurfaceIndex& surface, CutPatch patch,
                              std::vector<SurfaceNear>* near = nullptr);

}  // namespace kerf
