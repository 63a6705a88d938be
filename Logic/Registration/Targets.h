#pragma once

#include <vector>

#include "Core/Camera.h"
#include "Core/Embedding.h"
#include "Core/Features.h"
#include "Core/TetMesh.h"
#include "Geometry/SurfaceTree.h"

namespace kerf {

/// 2-D features bound to the rest surface of the registered organ (step [2] of Fig. 1 at
/// initialization).
struct BoundFeatures {
  Embedding embedding;            ///< P_F in the organ mesh, weights 0 off the boundary triangle
  Points rest;                    ///< N×3, P_F⁰, mm
  Eigen::VectorXd rest_depth_mm;  ///< camera depth of P_F⁰ at the moment of binding
  std::vector<char> on_surface;   ///< 0: the ray misses the organ by more than `reach_mm`; the
                                  ///< feature takes no part
};

/// Boundary of a mesh prepared for binding: tree over the positions, tetrahedron behind each
/// triangle.
class BindingSurface {
 public:
  /// @param positions vertex positions in which rays are cast (rest, or current when features are
  /// born later)
  BindingSurface(const TetMesh& mesh, const Points& positions);
  const SurfaceTree& Tree() const { return tree_; }
  /// Binds pixels by ray casting; rays that pass within `reach_mm` of the rim are bound to the
  /// nearest point there.
  BoundFeatures Bind(const Pixels& pixels, const CameraModel& camera, double reach_mm = 2.0) const;

 private:
  const TetMesh& mesh_;
  std::vector<Index> vertex_of_point_,
      tet_of_triangle_;  // filled while surface_ is made: before it
  SurfaceMesh surface_;
  SurfaceTree tree_;
};

/// Targets P_F¹ of tracked pixels. Our reading of "with the mapping to the surface": the viewing
/// ray at the feature's depth when it was bound. (The ray cut with the moving surface does not
/// converge, docs/decisions.)
/// @param pixels N×2 raw distorted; @return N×3, LPS, mm
Points TargetsAtRestDepth(const Pixels& pixels, const Eigen::VectorXd& rest_depth_mm,
                          const CameraModel& camera);

}  // namespace kerf
