#pragma once

#include <string>
#include <vector>

#include "Core/Progress.h"
#include "Core/TetMesh.h"
#include "Core/TopologyChange.h"
#include "Cutting/CutStructure.h"
#include "Cutting/TetCutter.h"

namespace kerf {

/// What planning makes of a label map. At rest, patient LPS, mm.
struct PlanningModel {
  TetMesh mesh;
  SurfaceMesh organ_surface;
  std::vector<Structure> structures;  ///< "internal", "tumour"
  double input_volume_mm3 = 0, edge_mm = 0;
  MeshQuality quality;
  Index points_outside = 0;
  double farthest_outside_mm = 0;
  /// Of each point of the organ's surface; empty without a tumour.
  std::vector<double> organ_to_tumour_mm;

  const SurfaceMesh* Find(const std::string& name) const;
};

/// A planned resection: a line on the organ's surface, extruded to a sheet.
struct ResectionPlan {
  double margin_mm = 5;         ///< wanted between tumour and cut
  Points line{0, 3};            ///< control points on the organ surface, in order
  Vec3 direction{0, 0, 1};      ///< into the tissue, unit vector
  double depth_mm = 40;         ///< of the sheet below the line
  bool follows_surface = true;  ///< the direction is the mean one into the surface
};

/// The line between its control points, on the surface, at most `step_mm` between two points.
/// Fewer than two control points give what there is.
Points LineOnSurface(const SurfaceMesh& organ, const Points& control, double step_mm = 2);

/// Mean inward normal of the surface along the line: the direction to start with.
Vec3 SuggestDirection(const SurfaceMesh& organ, const Points& line);

/// The sheet S: the line, lengthened at both ends by `beyond_mm`, from above the surface to the
/// depth. Empty for fewer than two points.
CutSurface ResectionSheet(const SurfaceMesh& organ, const ResectionPlan& plan,
                          double beyond_mm = 10);

/// Distances of points to a surface, mm ≥ 0, exact to the triangles.
std::vector<double> DistancesTo(const SurfaceMesh& surface, const Points& points);

struct ResectionMeasures {
  bool divides = false;   ///< the sheet cuts the organ into two or more pieces
  std::string note;       ///< what to do when it does not, or not along the whole sheet
  double organ_ml = 0;    ///< whole, tumour included
  double removed_ml = 0;  ///< the pieces with most of the tumour (without one: the smaller)
  double remnant_ml = 0, remnant_percent = 0;
  double tumour_left_ml = 0;  ///< tumour in the remnant: should be none
  /// Smallest distance of the sheet inside the organ; negative = there is no such structure or no
  /// sheet, 0 = the sheet goes through it.
  double to_tumour_mm = -1, to_internal_mm = -1;
  bool margin_kept = false;
  CutSurface sheet;
  std::vector<double> sheet_to_tumour_mm;  ///< per point of `sheet`; empty without a tumour
};

/// What the surgeon should know of a cut along the sheet; empty where all went well.
std::string ResectionNote(const CutReport& report, bool divides);

/// Cuts the model as the operating room would and measures. Deterministic.
/// @throws Cancelled
ResectionMeasures MeasureResection(const PlanningModel& model, const ResectionPlan& plan,
                                   Progress& progress);

/// Tissue (ml) of the organ at most margin_mm away from the tumour, the tumour included, from the
/// vertices' exact distances, linear within each tetrahedron: what an enucleation with this margin
/// takes. 0 without a tumour.
double TissueWithinMargin_ml(const PlanningModel& model, double margin_mm, Progress& progress);

}  // namespace kerf
