#pragma once

#include <array>
#include <memory>
#include <vector>

#include "Core/Features.h"
#include "Core/TetMesh.h"
#include "Cutting/CutStructure.h"
#include "Registration/CutEvidence.h"
#include "Registration/CutPolygon.h"
#include "Registration/GripFit.h"
#include "Registration/NeighborGraph.h"
#include "Registration/Silhouette.h"
#include "Registration/Targets.h"

namespace kerf {

/// One cut of the model.
struct ModelCut {
  CutPolygon polygon;              ///< evidence and committed line (reference method)
  CutPolyline line;                ///< committed line on the rest surface, mm
  Points redrawn;                  ///< M×3, as the evidence drew it when last there was enough, mm
  CutSurface surface;              ///< S so far, at rest
  Vec3 direction = Vec3::UnitZ();  ///< of the extrusion, unit, into the tissue
  Vec3 view = Vec3::UnitZ();       ///< along which the line is seen on the organ, unit
  int detected_frame = -1;
  double depth_mm = 0.0;               ///< reach of S below the surface
  double confidence = 0.0;             ///< 0..1
  std::array<double, 2> too_far_mm{};  ///< by this the evidence overshoots its first and last end
  bool held = false;                   ///< proposed only: S is known, the model is not cut yet
  bool rejected = false;  ///< by a surgeon: line and S are empty, the number stays taken
  bool in_model = false;  ///< the model has been cut along it (not held, not refused)
  bool partial = false;   ///< in the model, but a part of S stayed uncut (CutReport)
  bool drawn = false;     ///< by a surgeon's hand
};

/// The model before any cut.
struct UncutModel {
  TetMesh mesh;
  Embedding features;
  std::vector<Structure> structures;
};

/// When better cuts are searched for (Registration/ModelSearch.h).
struct ModelProbing {
  int next_frame = 0;      ///< the next search begins then, at the earliest
  int pause_frames = 0;    ///< after a search in vain
  int due_frame = -1;      ///< what the running search found is taken over then; −1: none runs
  bool turn = false;       ///< it tries directions, not ends
  bool of_grips = false;   ///< it tries the held parts, before any cut
  double regrip_mm = 0.0;  ///< the held parts are tried from this residual on
  int regrips = 0;         ///< searches for them so far
};

/// The only algorithmic memory of a registration (t): everything that one frame hands to the next.
struct RegistrationState {
  int frame = -1;
  TetMesh mesh;                              ///< (P_V⁰, C_V^t)
  Points positions;                          ///< P_V^t, mm
  Points velocities;                         ///< mm/s
  FeatureSet features;                       ///< p_f
  BoundFeatures bound;                       ///< P_F⁰ and its embedding in the current mesh
  NeighborGraph neighbors;                   ///< C_F^t
  std::vector<Structure> structures;         ///< P_I⁰, C_I^t
  CutEvidence evidence;                      ///< what spoke for cuts so far (Kerf's detection)
  std::shared_ptr<const UncutModel> origin;  ///< what a cut with another direction starts from
  std::shared_ptr<const SurfaceTree> uncut;  ///< the organ's rest surface before any cut
  Points blind_outline;                      ///< rest places whose outline is hidden, mm
  BoundaryTopology boundary;                 ///< of `mesh`
  GripFit grips;                             ///< loads that explain the tracks (Kerf's method)
  ModelProbing probing;
  std::vector<ModelCut> cuts;  ///< p_C, S
};

}  // namespace kerf
