#pragma once

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <cstdint>

/// Kerf: surgical augmented reality that survives the cut.
/// Frames and units everywhere in Logic: patient LPS, mm, s; masses in g, so that stress is in Pa;
/// E enters in kPa. Camera frame as OpenCV: x right, y down, z forward, pixel centres at integers.
namespace kerf {

using Index = std::int32_t;

/// N×3 points, mm, row-major: VTK and OpenCV map them without a copy.
using Points = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;
/// N×2 pixels (u right, v down).
using Pixels = Eigen::Matrix<double, Eigen::Dynamic, 2, Eigen::RowMajor>;
/// F×3 vertex indices, counter-clockwise seen from outside.
using Triangles = Eigen::Matrix<Index, Eigen::Dynamic, 3, Eigen::RowMajor>;
/// T×4 vertex indices, det(x1−x0, x2−x0, x3−x0) > 0.
using Tets = Eigen::Matrix<Index, Eigen::Dynamic, 4, Eigen::RowMajor>;
/// N×4 barycentric weights, rows sum to 1.
using Weights4 = Eigen::Matrix<double, Eigen::Dynamic, 4, Eigen::RowMajor>;

using Vec2 = Eigen::Vector2d;
using Vec3 = Eigen::Vector3d;
using Vec4 = Eigen::Vector4d;
using Mat3 = Eigen::Matrix3d;

/// Labels of organ voxels and tetrahedra (DESIGN §3: `--labels`).
enum class Label : std::uint8_t { Background = 0, Organ = 1, Tumour = 2, Internal = 3 };

}  // namespace kerf
