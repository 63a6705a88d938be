#include "Cutting/ExtrudePolyline.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

namespace kerf {
namespace {

constexpr double kSamePoint_mm = 1e-9;

void Check(const Points& polyline, const Points& directions, double above_mm, double depth_mm,
           double spacing_mm) {
  if (directions.rows() != polyline.rows() && directions.rows() != 1)
    throw std::invalid_argument("ExtrudePolyline: one direction for each point, or one for all");
  if (!polyline.allFinite() || !directions.allFinite())
    throw std::invalid_argument("ExtrudePolyline: a coordinate is not a finite number");
  if (!(spacing_mm > 0) || !(above_mm >= 0) || !(depth_mm >= 0) || !(above_mm + depth_mm > 0) ||
      !std::isfinite(above_mm + depth_mm))
    throw std::invalid_argument("ExtrudePolyline: lengths must be positive");
  for (Index i = 0; i < directions.rows(); ++i)
    if (!(directions.row(i).norm() > 1e-12))
      throw std::invalid_argument("ExtrudePolyline: a direction is zero");
}

}  // namespace

CutSurface ExtrudePolyline(const Points& polyline, const Points& directions, double above_mm,
                           double depth_mm, double spacing_mm) {
  Check(polyline, directions, above_mm, depth_mm, spacing_mm);
  auto direction = [&](Index i) -> Vec3 {
    return directions.row(directions.rows() == 1 ? 0 : i).transpose().normalized();
  };
  std::vector<Index> corners;  // polyline points that differ from the one before
  for (Index i = 0; i < polyline.rows(); ++i)
    if (corners.empty() || (polyline.row(i) - polyline.row(corners.back())).norm() > kSamePoint_mm)
      corners.push_back(i);

  CutSurface surface;
  if (corners.size() < 2) {
    surface.points.resize(0, 3);
    surface.triangles.resize(0, 3);
    return surface;
  }
  std::vector<Vec3> feet, along;  // where each column of the strip stands, and its direction
  for (std::size_t s = 0; s + 1 < corners.size(); ++s) {
    const Vec3 a = polyline.row(corners[s]).transpose();
    const Vec3 b = polyline.row(corners[s + 1]).transpose();
    const Vec3 da = direction(corners[s]), db = direction(corners[s + 1]);
    const int pieces = std::max(1, int(std::ceil((b - a).norm() / spacing_mm - 1e-9)));
    for (int k = 0; k < pieces; ++k) {
      const double t = double(k) / pieces;
      const Vec3 d = (1 - t) * da + t * db;
      feet.push_back(k == 0 ? a : Vec3((1 - t) * a + t * b));
      along.push_back(k == 0 || d.norm() < 1e-6 ? da : Vec3(d.normalized()));
    }
  }
  feet.push_back(polyline.row(corners.back()).transpose());
  along.push_back(direction(corners.back()));

  const Index columns = static_cast<Index>(feet.size());
  const Index rows =
      std::max(1, int(std::ceil((above_mm + depth_mm) / spacing_mm - 1e-9)));  // cells in depth
  surface.points.resize(columns * (rows + 1), 3);
  surface.triangles.resize(2 * (columns - 1) * rows, 3);
  for (Index i = 0; i < columns; ++i)
    for (Index j = 0; j <= rows; ++j) {
      const double depth = -above_mm + (above_mm + depth_mm) * j / rows;
      surface.points.row(i * (rows + 1) + j) = (feet[i] + depth * along[i]).transpose();
    }
  Index f = 0;
  for (Index i = 0; i + 1 < columns; ++i)
    for (Index j = 0; j < rows; ++j) {
      const Index a = i * (rows + 1) + j, b = a + rows + 1;
      surface.triangles.row(f++) << a, b, b + 1;
      surface.triangles.row(f++) << a, b + 1, a + 1;
    }
  return surface;
}

CutSurface ExtrudePolyline(const CutPolyline& polyline, const Vec3& direction, double above_mm,
                           double depth_mm, double spacing_mm) {
  Points directions(1, 3);
  directions.row(0) = direction.transpose();
  return ExtrudePolyline(polyline.points, directions, above_mm, depth_mm, spacing_mm);
}

}  // namespace kerf
