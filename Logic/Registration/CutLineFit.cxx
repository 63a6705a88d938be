#include "Registration/CutLineFit.h"

#include <algorithm>
#include <cmath>

namespace kerf {
namespace {

/// Near its tip a crack opens with the square root of the distance: extrapolate the opening's
/// square to zero.
/// @param along positions measured away from the tip; @param opening_mm at these; @return distance
/// of the tip beyond 0
double TipReach(const std::vector<double>& along, const std::vector<double>& opening_mm,
                double longest) {
  double s = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (std::size_t i = 0; i < along.size(); ++i) {
    if (along[i] > 4.0 * longest) continue;
    const double y = opening_mm[i] * opening_mm[i];
    s += 1;
    sx += along[i];
    sy += y;
    sxx += along[i] * along[i];
    sxy += along[i] * y;
  }
  const double det = s * sxx - sx * sx;
  if (s < 3 || det < 1e-9) return 0.5 * longest;
  const double slope = (s * sxy - sx * sy) / det, at_zero = (sy - slope * sx) / s;
  if (slope <= 1e-9) return 0.5 * longest;
  return std::clamp(at_zero / slope, 0.0, longest);
}

}  // namespace

FittedLine FitCutLine(const std::vector<PartingEdge>& parting, const std::vector<Index>& group,
                      const FeatureTriangulation& t, const DisplacementJumps& jumps) {
  const std::size_t n = group.size();
  std::vector<Vec2> middle(n);
  std::vector<double> weight(n);
  Vec2 jump_sum = Vec2::Zero(), origin = Vec2::Zero();
  double weight_sum = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    const PartingEdge& p = parting[group[i]];
    const auto [l, m] = t.edges[p.edge];
    middle[i] = 0.5 * (t.rest.row(l) + t.rest.row(m)).transpose();
    weight[i] = std::min(p.excess_mm, 5.0) / std::pow(std::max(t.length_mm[p.edge], 1.0), 2);
    Vec2 jump = jumps.Jump_mm(t, p.edge);
    if (jump.dot(jump_sum) < 0.0) jump = -jump;
    jump_sum += weight[i] * jump.normalized();
    origin += weight[i] * middle[i];
    weight_sum += weight[i];
  }
  origin /= weight_sum;
  // Tangent: across the opening while the evidence is short, along the evidence when it is long.
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
  for (std::size_t i = 0; i < n; ++i)
    scatter += weight[i] * (middle[i] - origin) * (middle[i] - origin).transpose() / weight_sum;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(scatter);
  const double extent = std::sqrt(std::max(0.0, eigen.eigenvalues()[1]));
  Vec2 across_opening(-jump_sum.y(), jump_sum.x());
  across_opening.normalize();
  Vec2 along = eigen.eigenvectors().col(1);
  if (along.dot(across_opening) < 0.0) along = -along;
  const double trust = std::clamp(extent / t.spacing_mm - 1.0, 0.0, 1.0);

  FittedLine line;
  line.origin = origin;
  line.tangent = (trust * along + (1.0 - trust) * across_opening).normalized();
  line.normal = Vec2(-line.tangent.y(), line.tangent.x());
  std::vector<double> s(n), o(n);
  line.begin_mm = 1e30;
  line.end_mm = -1e30;
  for (std::size_t i = 0; i < n; ++i) {
    s[i] = line.tangent.dot(middle[i] - origin);
    o[i] = line.normal.dot(middle[i] - origin);
    line.begin_mm = std::min(line.begin_mm, s[i]);
    line.end_mm = std::max(line.end_mm, s[i]);
  }
  const double length = line.end_mm - line.begin_mm;
  const int degree = length > 5.0 * t.spacing_mm ? 2 : length > 2.0 * t.spacing_mm ? 1 : 0;
  Mat3 a = Mat3::Zero();
  Vec3 b = Vec3::Zero();
  for (std::size_t i = 0; i < n; ++i) {
    Vec3 basis(1.0, degree > 0 ? s[i] : 0.0, degree > 1 ? s[i] * s[i] : 0.0);
    a += weight[i] * basis * basis.transpose();
    b += weight[i] * o[i] * basis;
  }
  // Bending costs: straight where the evidence does not ask for more.
  a += weight_sum * Vec3(1e-9, 1e-3 * length * length, 1e-3 * std::pow(length, 4)).asDiagonal();
  a += 1e-12 * Mat3::Identity();
  line.offset = a.ldlt().solve(b);
  std::vector<double> from_begin, from_end, opening;
  for (std::size_t i = 0; i < n; ++i) {
    from_begin.push_back(s[i] - line.begin_mm);
    from_end.push_back(line.end_mm - s[i]);
    opening.push_back(parting[group[i]].jump_mm);
  }
  line.begin_tip_mm = TipReach(from_begin, opening, t.spacing_mm);
  line.end_tip_mm = TipReach(from_end, opening, t.spacing_mm);
  return line;
}

}  // namespace kerf
