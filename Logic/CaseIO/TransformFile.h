#pragma once

#include <Eigen/Geometry>
#include <string>

namespace kerf {

/// Reads a linear transform, LPS, mm, that moves points (of a second CT) to where they belong (in
/// the case). Two forms: sixteen numbers, row by row, the last row 0 0 0 1, taken as they stand; or
/// an ITK transform file (.tfm) with one AffineTransform or MatrixOffsetTransformBase, which Slicer
/// stores *from parent*: it is inverted.
/// @throws InputError naming file and element: other types, .h5, not invertible, not a number
Eigen::Affine3d ReadTransformFile(const std::string& path);

}  // namespace kerf
