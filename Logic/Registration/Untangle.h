#pragma once

#include "Core/TetMesh.h"

namespace kerf {

/// Corotational elasticity stays finite through inversion, so strong loads can leave an element
/// flat or inside out. Moves the vertices of such elements, and only these, towards their element's
/// rest shape, rotated and translated to where the element is (shape matching), until every element
/// is positive with a dihedral angle of at least `least_dihedral_deg`, or `rounds` are spent.
/// @param positions N×3, in and out, mm
/// @return number of vertices that were moved; 0 in the usual case, after one pass over the
/// elements
int Untangle(const TetMesh& mesh, Points* positions, double least_dihedral_deg = 1.0,
             int rounds = 200);

}  // namespace kerf
