#include "Registration/Untangle.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <numeric>
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

/// Those of `watch` that are inverted or slivers, in its order.
std::vector<Index> BadOnes(const TetMesh& mesh, const Points& positions,
                           const std::vector<Index>& watch, double least_dihedral_deg) {
  constexpr std::size_t kChunk = 2048;
  std::vector<char> is_bad(watch.size(), 0);
  tbb::parallel_for(std::size_t{0}, (watch.size() + kChunk - 1) / kChunk, [&](std::size_t chunk) {
    for (std::size_t i = chunk * kChunk; i < std::min(watch.size(), (chunk + 1) * kChunk); ++i)
      is_bad[i] = Bad(CornersOf(positions, mesh.tets, watch[i]),
                      Volume6(CornersOf(mesh.rest, mesh.tets, watch[i])), least_dihedral_deg);
  });
  std::vector<Index> bad;
  for (std::size_t i = 0; i < watch.size(); ++i)
    if (is_bad[i]) bad.push_back(watch[i]);
  return bad;
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

/// Elements at each vertex: those of v are tets[begin[v]] … tets[begin[v + 1] − 1], rising.
struct Incidence {
  std::vector<std::size_t> begin;
  std::vector<Index> tets;
};

Incidence IncidenceOf(const TetMesh& mesh) {
  Incidence out;
  std::vector<std::size_t> next(mesh.VertexCount() + 1, 0);
  for (Index t = 0; t < mesh.TetCount(); ++t)
    for (int k = 0; k < 4; ++k) ++next[mesh.tets(t, k) + 1];
  std::partial_sum(next.begin(), next.end(), next.begin());
  out.begin = next;
  out.tets.resize(4 * static_cast<std::size_t>(mesh.TetCount()));
  for (Index t = 0; t < mesh.TetCount(); ++t)
    for (int k = 0; k < 4; ++k) out.tets[next[mesh.tets(t, k)]++] = t;
  return out;
}

}  // namespace

int Untangle(const TetMesh& mesh, Points* positions, double least_dihedral_deg, int rounds) {
  std::vector<Index> watch(mesh.TetCount());
  std::iota(watch.begin(), watch.end(), 0);
  std::vector<Index> bad;
  if (rounds > 0) bad = BadOnes(mesh, *positions, watch, least_dihedral_deg);
  if (bad.empty()) return 0;
  const Incidence at = IncidenceOf(mesh);
  std::vector<char> moved(mesh.VertexCount(), 0), watched(mesh.TetCount(), 0);
  for (int round = 1; !bad.empty(); ++round) {
    for (Index t : bad) {
      const Corners now = CornersOf(*positions, mesh.tets, t);
      const Corners goal = Matched(CornersOf(mesh.rest, mesh.tets, t), now);
      for (int k = 0; k < 4; ++k) {
        positions->row(mesh.tets(t, k)) += 0.5 * (goal.row(k) - now.row(k));
        moved[mesh.tets(t, k)] = 1;
      }
    }
    if (round == rounds) break;
    // Only elements at a vertex that has just been moved can be bad now.
    watch.clear();
    for (Index t : bad)
      for (int k = 0; k < 4; ++k)
        for (std::size_t i = at.begin[mesh.tets(t, k)]; i < at.begin[mesh.tets(t, k) + 1]; ++i) {
          if (watched[at.tets[i]]) continue;
          watched[at.tets[i]] = 1;
          watch.push_back(at.tets[i]);
        }
    for (Index t : watch) watched[t] = 0;
    std::sort(watch.begin(), watch.end());
    bad = BadOnes(mesh, *positions, watch, least_dihedral_deg);
  }
  return static_cast<int>(std::count(moved.begin(), moved.end(), 1));
}

}  // namespace kerf
