#include "Registration/CutLine.h"

#include <algorithm>
#include <cmath>

namespace kerf {
namespace {

constexpr double kBehind_mm = 500.0;  // rays start well in front of the organ
constexpr double kOnSurface_mm =
    0.1;  // a face centre farther from the uncut surface than this is a cut face

}  // namespace

Points LedOn(const Points& line, bool at_end, const Vec3& tip) {
  const Index n = static_cast<Index>(line.rows());
  Points longer(n + 1, 3);
  longer.middleRows(at_end ? 0 : 1, n) = line;
  longer.row(at_end ? n : 0) = tip.transpose();
  return longer;
}

Points Shortened(const Points& line, bool at_end, double by_mm) {
  const Index n = static_cast<Index>(line.rows());
  for (Index cut_off = 1; cut_off < n; ++cut_off) {
    const Index end = at_end ? n - cut_off : cut_off - 1, next = at_end ? end - 1 : end + 1;
    const double length = (line.row(end) - line.row(next)).norm();
    if (length <= by_mm) {
      by_mm -= length;
      continue;
    }
    Points shorter =
        at_end ? Points(line.topRows(n - cut_off + 1)) : Points(line.bottomRows(n - cut_off + 1));
    shorter.row(at_end ? n - cut_off : 0) += by_mm / length * (line.row(next) - line.row(end));
    return shorter;
  }
  return Points(0, 3);
}

double DistanceToLine(const Points& line, const Vec3& p) {
  double best = 1e30;
  for (Index i = 0; i + 1 < line.rows(); ++i) {
    const Vec3 a = line.row(i).transpose(), ab = line.row(i + 1).transpose() - a;
    const double t = std::clamp(ab.dot(p - a) / std::max(ab.squaredNorm(), 1e-12), 0.0, 1.0);
    best = std::min(best, (a + t * ab - p).norm());
  }
  return best;
}

Points LineOnSurface(const CutPolyline& line, const Vec3& direction, const SurfaceTree& surface,
                     double step_mm) {
  std::vector<Vec3> hits;
  const auto cast = [&](const Vec3& p) {
    if (const auto hit = surface.FirstHit({p - kBehind_mm * direction, direction}))
      hits.push_back(hit->point);
  };
  for (Index i = 0; i + 1 < line.points.rows(); ++i) {
    const Vec3 a = line.points.row(i).transpose(), b = line.points.row(i + 1).transpose();
    const int steps = std::max(1, static_cast<int>(std::ceil((b - a).norm() / step_mm)));
    for (int k = 0; k < steps; ++k) cast(a + (b - a) * (double(k) / steps));
  }
  if (line.points.rows() > 0) cast(line.points.bottomRows(1).transpose());
  Points out(hits.size(), 3);
  for (std::size_t i = 0; i < hits.size(); ++i) out.row(i) = hits[i].transpose();
  return out;
}

std::vector<std::uint8_t> CutFaceFlags(const SurfaceMesh& boundary, const SurfaceTree& uncut) {
  std::vector<std::uint8_t> flags(boundary.triangles.rows(), 0);
  for (Index t = 0; t < boundary.triangles.rows(); ++t) {
    const auto corner = boundary.triangles.row(t);
    const Vec3 center = (boundary.points.row(corner[0]) + boundary.points.row(corner[1]) +
                         boundary.points.row(corner[2]))
                            .transpose() /
                        3.0;
    flags[t] = uncut.Closest(center).distance_mm > kOnSurface_mm;
  }
  return flags;
}

}  // namespace kerf
