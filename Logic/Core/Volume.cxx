#include "Core/Volume.h"

#include <algorithm>
#include <cmath>

#include "Core/Errors.h"

namespace kerf {

bool GridGeometry::SameAs(const GridGeometry& other, double tolerance_mm) const {
  return size == other.size &&
         (spacing_mm - other.spacing_mm).cwiseAbs().maxCoeff() <= tolerance_mm &&
         (origin_mm - other.origin_mm).cwiseAbs().maxCoeff() <= 100 * tolerance_mm &&
         (direction - other.direction).cwiseAbs().maxCoeff() <= 1e-3;
}

void GridGeometry::Validate(const std::string& file) const {
  if (size.minCoeff() <= 0) throw InputError(file, "size", "a dimension is zero or negative");
  if (!spacing_mm.allFinite()) throw InputError(file, "spacing", "not a number");
  if (spacing_mm.minCoeff() <= 0) throw InputError(file, "spacing", "must be positive");
  if (!origin_mm.allFinite()) throw InputError(file, "origin", "not a number");
  if (!direction.allFinite()) throw InputError(file, "direction", "not a number");
  const Mat3 gram = direction.transpose() * direction;
  if ((gram - Mat3::Identity()).cwiseAbs().maxCoeff() > 1e-2)
    throw InputError(file, "direction", "axes are not orthonormal");
}

double LabelMap::LabelVolume_mm3(Label label) const {
  const auto n = std::count(voxels->begin(), voxels->end(), static_cast<std::uint8_t>(label));
  return static_cast<double>(n) * grid.VoxelVolume_mm3();
}

}  // namespace kerf
