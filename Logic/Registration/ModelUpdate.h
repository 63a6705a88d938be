#pragma once

#include <optional>
#include <string>
#include <vector>

#include "Registration/Step.h"

namespace kerf {

/// Extrusion of the cut line to the separation surface S ("Expansion to cut surface"): from in
/// front of the organ's surface to `depth_mm` below it. @param direction unit, into the tissue
CutSurface ExtrudeCut(const CutPolyline& line, const Vec3& direction, double depth_mm);

/// Cuts model and inner structures along the S of `cut` and carries features, velocities and solver
/// over by provenance. A refused increment leaves the state as it was.
CutReport ApplyCut(const ModelCut& cut, const MethodOptions& options, Engine& engine,
                   RegistrationState* state);

/// The uncut model cut anew along all of `cuts` (proposals that are held and rejected ones left
/// out), at the positions that state has now.
struct CutModel {
  TetMesh mesh;
  Points positions, grip_positions;
  Embedding features;
  std::vector<Structure> structures;
  BoundaryTopology boundary;
  std::vector<std::string> uncut;  ///< cut → why a part of its S stays uncut; empty: none does
  TetCutter cutter;
  Solvers solvers;  ///< set up with it; none: Adopt starts them afresh
};
/// @param whole false: a trial, without structures and boundary. @param start where the uncut
/// mesh's vertices begin, instead of the state's positions. @return none when a cut is refused
std::optional<CutModel> CutAnew(const std::vector<ModelCut>& cuts, const MethodOptions& options,
                                const RegistrationState& state, bool whole,
                                const Points* start = nullptr);
/// Puts it in the place of the state's; the solvers start afresh.
void Adopt(CutModel model, const MethodOptions& options, Engine& engine, RegistrationState* state);

}  // namespace kerf
