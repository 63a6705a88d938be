#include "Session/PlanDeviation.h"

#include <algorithm>

namespace kerf {

PlanDeviation MeasurePlanDeviation(const OrganView& organ, const SurfaceTree& sheet) {
  struct Piece {
    double distance_mm, area_mm2;
  };
  std::vector<Piece> pieces;
  double area_mm2 = 0.0, sum = 0.0;
  const Triangles& triangles = organ.current.triangles;
  for (Index t = 0; t < triangles.rows(); ++t) {
    if (!organ.cut_face[t]) continue;
    const auto corner = [&](int k) -> Vec3 { return organ.rest.row(triangles(t, k)).transpose(); };
    const Vec3 a = corner(0), b = corner(1), c = corner(2);
    const Piece piece{sheet.Closest((a + b + c) / 3.0).distance_mm,
                      0.5 * (b - a).cross(c - a).norm()};
    area_mm2 += piece.area_mm2;
    sum += piece.distance_mm * piece.area_mm2;
    pieces.push_back(piece);
  }
  PlanDeviation out;
  if (!(area_mm2 > 0)) return out;
  std::sort(pieces.begin(), pieces.end(),
            [](const Piece& a, const Piece& b) { return a.distance_mm < b.distance_mm; });
  out.mean_mm = sum / area_mm2;
  out.max_mm = pieces.back().distance_mm;
  double nearer_mm2 = 0.0;
  for (const Piece& piece : pieces) {
    out.p95_mm = piece.distance_mm;
    nearer_mm2 += piece.area_mm2;
    if (nearer_mm2 >= 0.95 * area_mm2) break;
  }
  return out;
}

}  // namespace kerf
