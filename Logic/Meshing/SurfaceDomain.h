#pragma once

#include <memory>
#include <string>

#include "Core/SurfaceMesh.h"
#include "Meshing/DomainMesher.h"

namespace kerf {

/// The inside of a closed surface; edges sharper than 50° are kept as edges of the mesh.
/// @param surface one that passes RequireClosedSurface
std::unique_ptr<DomainMesher> MakeSurfaceDomain(const SurfaceMesh& surface);

/// @throws InputError naming `file` and the triangle or edge: not finite, open, not manifold,
/// triangles of opposite orientation, turned inside out, self-intersecting
void RequireClosedSurface(const SurfaceMesh& surface, const std::string& file);

}  // namespace kerf
