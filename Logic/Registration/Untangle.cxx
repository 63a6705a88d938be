#include "Registration/Untangle.h"

#include <algorithm>
#include <array>
#include <vector>

namespace kerf {
namespace {

using Corners = Eigen::Matrix<double, 4, 3>;

Corners CornersOf(const Points& points, const Tets& tets, Index t) {
  Corners c;
  for (int k = 0; k < 4; ++k) c.row(k) = points.row(tets(t, k));
  return c;
}

double Volume6(const Corners& c) {
  const Eigen::RowVector3d a = c.row(1) - c.row(0), b = c.row(2) - c.row(0),
                           d = c.row(3) - c.row(0);
  return a.dot(b.cross(d));
}

bool Bad(const Corners& now, double rest_volume6, double least_dihedral_deg) {
  const double volume = Volume6(now);
  if (volume <= 0.0) return true;
  if (volume > 0.35 * rest_volume6) return false;  // cannot be a sliver that the rest is not
  return SmallestDihedral_deg(now.row(0).transpose(), now.row(1).transpose(),
                              now.row(2).transpose(), now.row(3).transpose()) < least_dihedral_deg;
}

/// The rest shape where the element is now: best rotation (never a reflection) and translation.
Corners Matched(const Corners& rest, const Corners& now) {
  const Eigen::RowVector3d rest_center = rest.colwise().mean(), center = now.colwise().mean();
  const Mat3 covariance = (now.rowwise() - center).transpose() * (rest.rowwise() - rest_center);
  const Eigen::JacobiSVD<Mat3> svd(covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Mat3 flip = Mat3::Identity();
  if ((svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0) flip(2, 2) = -1.0;
  const Mat3 rotation = svd.matrixU() * flip * svd.matrixV().transpose();
  return ((rest.rowwise() - rest_center) * rotation.transpose()).rowwise() + center;
}

}  // namespace

int Untangle(const TetMesh& mesh, Points* positions, double least_dihedral_deg, int rounds) {
  std::vector<char> moved(mesh.VertexCount(), 0);
  std::vector<Index> watch(mesh.TetCount()), bad;
  for (Index t = 0; t < mesh.TetCount(); ++t) watch[t] = t;
  for (int round = 0; round < rounds; ++round) {
    bad.clear();
    for (Index t : watch)
      if (Bad(CornersOf(*positions, mesh.tets, t), Volume6(CornersOf(mesh.rest, mesh.tets, t)),
              least_dihedral_deg))
        bad.push_back(t);
    if (bad.empty()) break;
    for (Index t : bad) {
      const Corners now = CornersOf(*positions, mesh.tets, t);
      const Corners goal = Matched(CornersOf(mesh.rest, mesh.tets, t), now);
      for (int k = 0; k < 4; ++k) {
        positions->row(mesh.tets(t, k)) += 0.5 * (goal.row(k) - now.row(k));
        moved[mesh.tets(t, k)] = 1;
      }
    }
    // From now on only elements at a vertex that has moved can be bad.
    watch.clear();
    for (Index t = 0; t < mesh.TetCount(); ++t)
      if (moved[mesh.tets(t, 0)] || moved[mesh.tets(t, 1)] || moved[mesh.tets(t, 2)] ||
          moved[mesh.tets(t, 3)])
        watch.push_back(t);
  }
  return static_cast<int>(std::count(moved.begin(), moved.end(), 1));
}

}  // namespace kerf
