#pragma once

#include "Core/Volume.h"

namespace kerf::testing {

/// CT of one ellipsoid organ (165 HU) in fat (−100 HU), some air in front, with a tumour (80 HU)
/// and a bright inner tube (400 HU); 2 mm voxels, a little noise from a fixed seed. LPS, the organ
/// is centred at the origin with half axes 36 × 24 × 22 mm: 79.6 ml; the tumour is a ball of 7 mm
/// at (16, −8, 2).
Volume SmallCt();
/// The same organ `scale` times as large on another grid, which is centred on it.
Volume EllipsoidCt(const Eigen::Vector3i& size, const Vec3& spacing_mm, double scale);

}  // namespace kerf::testing
