#pragma once

#include <functional>
#include <vector>

#include "Core/SurfaceMesh.h"

namespace kerf {

using ImplicitFunction = std::function<double(const Vec3&)>;  ///< negative inside, smooth, about mm

/// Zero surface of an implicit function on a regular grid of tetrahedra, vertices projected onto
/// the surface. Sheets x = sheet_x(y) + n · cell can divide the body: then its pieces are meshed up
/// to the sheets with identical rim vertices.
struct ImplicitMeshRequest {
  ImplicitFunction f;
  Vec3 low = Vec3::Zero(), high = Vec3::Zero();  ///< box that holds the surface, mm
  double cell_mm = 2.0;
  std::vector<int> sheets;  ///< n of each sheet, ascending from 0; empty: not divided
  std::function<double(double y)> sheet_x;  ///< used when divided
};

struct ImplicitMesh {
  /// The outer surface between the sheets, ascending in x, open at them; closed when not divided.
  std::vector<SurfaceMesh> pieces;
  std::vector<SurfaceMesh> sections;  ///< of the body with each sheet, normals towards +x
};

ImplicitMesh MeshImplicit(const ImplicitMeshRequest& request);

}  // namespace kerf
