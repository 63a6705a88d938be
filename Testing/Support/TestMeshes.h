#pragma once

#include "Core/SurfaceMesh.h"
#include "Core/TetMesh.h"
#include "Core/TopologyChange.h"

/// Meshes for tests, all at rest in LPS mm, region = organ, positive tetrahedra.
namespace kerf::testing {

/// Box centred at the origin, a grid of cells with six tetrahedra each (smallest dihedral 45° for
/// cubes).
TetMesh BoxMesh(const Vec3& size_mm, int cells_x, int cells_y, int cells_z);

/// Silicone band 120 × 40 × 10 mm along x, thickness along z; about `tets` tetrahedra.
TetMesh BandMesh(int tets = 6000);

/// Ellipsoid with these half axes: 20·n³ tetrahedra around the centre (n = 9: 14,580; n = 13:
/// 43,940), smallest dihedral above 20° for a sphere.
TetMesh EllipsoidMesh(const Vec3& half_axes_mm, int n);
TetMesh SphereMesh(double radius_mm, int n);

/// `mesh` with its vertices moved at random (interior freely, boundary not at all) as far as every
/// dihedral angle stays ≥ `min_dihedral_deg`: an irregular, badly shaped mesh. @param amount
/// fraction of the shortest edge
TetMesh Jitter(TetMesh mesh, double amount, double min_dihedral_deg, unsigned seed);

/// Labels tetrahedra whose centroid lies within this sphere.
void PaintSphere(const Vec3& center, double radius_mm, Label label, TetMesh* mesh);

/// Rectangle spanned from `corner` by u and v, a regular grid of nu × nv cells with two triangles
/// each.
CutSurface RectangleCut(const Vec3& corner, const Vec3& u, const Vec3& v, int nu, int nv);
/// `surface` without the triangles whose middle is nearer to `center`.
CutSurface WithHole(const CutSurface& surface, const Vec3& center, double radius_mm);
/// Both in one, not joined.
CutSurface Together(const CutSurface& a, const CutSurface& b);

/// Geodesic sphere as a closed surface, outwards; 20·4^levels triangles.
SurfaceMesh SphereSurface(const Vec3& center, double radius_mm, int levels);

/// Closed tube around the straight line a–b (caps included), outwards.
SurfaceMesh TubeSurface(const Vec3& a, const Vec3& b, double radius_mm, int around, int along);

}  // namespace kerf::testing
