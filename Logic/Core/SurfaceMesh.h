#pragma once

#include <string>
#include <vector>

#include "Core/Types.h"

namespace kerf {

/// Triangle surface (P_I⁰, C_I⁰ of the paper when at rest).
struct SurfaceMesh {
  Points points;        ///< N×3, LPS, mm
  Triangles triangles;  ///< F×3, counter-clockwise seen from outside

  bool Empty() const { return triangles.rows() == 0; }
  /// @throws InputError naming `file` and the triangle or point: index out of range, NaN,
  /// degenerate to a point
  void Validate(const std::string& file) const;
  /// Signed volume by the divergence theorem, mm³: positive when closed and oriented outwards.
  double SignedVolume() const;
  double Area() const;
  /// Every edge has exactly two triangles of opposite direction.
  bool IsClosedManifold() const;
  /// Edge-connected components: component number of each triangle; returns their count.
  int Components(std::vector<Index>* component_of_triangle = nullptr) const;
};

}  // namespace kerf
