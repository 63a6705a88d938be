#pragma once

#include <string>
#include <vector>

#include "Core/SurfaceMesh.h"
#include "Core/Volume.h"
#include "Phantom/PhantomMotion.h"

namespace kerf {

/// Rest surfaces of the phantom, in organ axes, mm.
struct PhantomAnatomy {
  /// Outer surface and, where there are cuts, both faces of each sheet as separate, coinciding
  /// triangles.
  SurfaceMesh organ;
  std::vector<std::int8_t> organ_cut;     ///< per point: 0 outer surface, k + 1 face of cut k
  std::vector<std::int8_t> organ_region;  ///< per point: piece between the sheets, along +x
  SurfaceMesh internal, tumour;           ///< empty for bands
};

PhantomAnatomy BuildPhantomAnatomy(const PhantomSetup& setup);

/// A surface at one frame: closed parts of the sheets left out, or triangles that an opened sheet
/// crosses.
struct PhantomSurfaceAtFrame {
  SurfaceMesh mesh;        ///< organ axes, mm
  std::vector<Index> pid;  ///< index in the rest surface, per point
};

PhantomSurfaceAtFrame OrganAtFrame(const PhantomAnatomy& anatomy, const PhantomMotion& motion,
                                   double frame);
/// Same points in the same order as at rest; only triangles that cross an opened sheet are
/// missing.
SurfaceMesh StructureAtFrame(const SurfaceMesh& rest, const PhantomMotion& motion, double frame);
/// Opened part of the sheet of a cut at rest; `depth_mm` per point.
SurfaceMesh OpenedSheet(const PhantomAnatomy& anatomy, const PhantomMotion& motion, int cut,
                        double frame, std::vector<float>* depth_mm);

/// The line of a cut at rest on the camera side of the organ, from the entry edge to `depth_mm` or
/// to the far edge, about every 0.75 mm.
Points CutLine(const PhantomSetup& setup, const PhantomMotion& motion, int cut, double depth_mm);

/// `points` (organ axes) in patient LPS.
Points ToWorld(const Points& points, const Eigen::Isometry3d& world_from_organ);

}  // namespace kerf
