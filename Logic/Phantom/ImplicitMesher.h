#pragma once

#include <functional>

#include "Core/SurfaceMesh.h"

namespace kerf {

using ImplicitFunction = std::function<double(const Vec3&)>;  ///< negative inside, smooth, about mm

/// Zero surface of an implicit function on a regular grid of tetrahedra, vertices projected onto
/// the surface. A sheet x = sheet_x(y) can divide the body: then both pieces are meshed up to the
/// sheet with identical rim vertices.
struct ImplicitMeshRequest {
  ImplicitFunction f;
  Vec3 low = Vec3::Zero(), high = Vec3::Zero();  ///< box that holds the surface, mm
  double cell_mm = 2.0;
  bool divided = false;
  std::function<double(double y)> sheet_x;  ///< used when divided
};

struct ImplicitMesh {
  SurfaceMesh whole;  ///< when not divided: closed
  SurfaceMesh minus,
      plus;  ///< when divided: the outer surface on either side of the sheet, open at the sheet
  SurfaceMesh section;  ///< when divided: the body's section with the sheet, normals towards +x
};

ImplicitMesh MeshImplicit(const ImplicitMeshRequest& request);

}  // namespace kerf
