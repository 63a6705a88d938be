#pragma once

#include "Core/Types.h"

namespace kerf::testing {

/// A vector of three draws, one after the other: as arguments of one call they would be made in
/// whatever order the compiler likes. The last component is drawn first.
template <class Draw>
Vec3 DrawVec3(Draw draw) {
  const double z = draw();
  const double y = draw();
  const double x = draw();
  return {x, y, z};
}

/// The same in the plane.
template <class Draw>
Vec2 DrawVec2(Draw draw) {
  const double y = draw();
  const double x = draw();
  return {x, y};
}

}  // namespace kerf::testing
