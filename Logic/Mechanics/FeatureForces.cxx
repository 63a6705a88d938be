#include "Mechanics/FeatureForces.h"

#include <cmath>
#include <string>

#include "Core/Errors.h"

namespace kerf {

SpringState EvaluateSpring(const Springs& springs, Index spring, const Vec3& p) {
  SpringState state;
  const double k = springs.stiffness[spring];
  if (k == 0.0) return state;
  const Vec3 d = p - springs.targets.row(spring).transpose();
  Mat3 Q = Mat3::Identity();
  if (springs.directions.rows() > 0) {
    const Vec3 n = springs.directions.row(spring).transpose();
    Q -= (1.0 - springs.along_factor) * n * n.transpose();
  }
  const Vec3 Qd = Q * d;
  const double r2 = d.dot(Qd);
  const double c2 = springs.robust_scale_mm * springs.robust_scale_mm;
  const double fade = c2 > 0.0 ? c2 / (c2 + r2) : 1.0;
  state.energy_nJ = 0.5 * k * r2 * fade;
  state.weight = fade * fade;
  state.gradient = k * state.weight * Qd;
  state.matrix = k * state.weight * Q;
  return state;
}

void ValidateSprings(const Springs& springs, Index tet_count) {
  const Index n = springs.at.Size();
  if (springs.at.weights.rows() != n || springs.targets.rows() != n ||
      springs.stiffness.size() != n)
    throw UsageError("springs: points, targets and stiffnesses differ in number");
  if (springs.directions.rows() != 0 && springs.directions.rows() != n)
    throw UsageError("springs: directions and points differ in number");
  for (Index l = 0; l < n; ++l) {
    const std::string name = "spring " + std::to_string(l);
    if (springs.at.tet[l] < 0 || springs.at.tet[l] >= tet_count)
      throw UsageError(name + ": no such tetrahedron");
    if (!(springs.stiffness[l] >= 0.0) || !std::isfinite(springs.stiffness[l]))
      throw UsageError(name + ": stiffness must be finite and not negative");
    if (springs.stiffness[l] == 0.0) continue;
    if (!springs.targets.row(l).allFinite() || !springs.at.weights.row(l).allFinite())
      throw UsageError(name + ": target or weights not finite");
    if (springs.directions.rows() > 0 && !(std::abs(springs.directions.row(l).norm() - 1.0) < 1e-6))
      throw UsageError(name + ": direction is not a unit vector");
  }
  if (!(springs.along_factor >= 0.0) || !(springs.robust_scale_mm >= 0.0))
    throw UsageError("springs: along factor and robust scale must not be negative");
}

void ValidateFixations(const Fixations& fixations, Index vertex_count) {
  if (fixations.targets.rows() != static_cast<Index>(fixations.vertices.size()))
    throw UsageError("fixations: vertices and targets differ in number");
  if (!(fixations.stiffness_g_s2 >= 0.0) || !std::isfinite(fixations.stiffness_g_s2))
    throw UsageError("fixations: stiffness must be finite and not negative");
  for (std::size_t i = 0; i < fixations.vertices.size(); ++i) {
    const Index v = fixations.vertices[i];
    if (v < 0 || v >= vertex_count || !fixations.targets.row(static_cast<Index>(i)).allFinite())
      throw UsageError("fixation " + std::to_string(i) + ": no such vertex or target not finite");
  }
}

SpringsByVertex SortSpringsByVertex(const Embedding& at, const Tets& tets, Index vertex_count) {
  SpringsByVertex sorted;
  sorted.begin.assign(vertex_count + 1, 0);
  for (Index t : at.tet)
    for (int k = 0; k < 4; ++k) ++sorted.begin[tets(t, k) + 1];
  for (Index v = 0; v < vertex_count; ++v) sorted.begin[v + 1] += sorted.begin[v];
  sorted.spring.resize(4 * at.tet.size());
  sorted.weight.resize(4 * at.tet.size());
  std::vector<Index> next(sorted.begin.begin(), sorted.begin.end() - 1);
  for (Index l = 0; l < at.Size(); ++l)
    for (int k = 0; k < 4; ++k) {
      const Index slot = next[tets(at.tet[l], k)]++;
      sorted.spring[slot] = l;
      sorted.weight[slot] = at.weights(l, k);
    }
  return sorted;
}

}  // namespace kerf
