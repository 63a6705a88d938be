#include "Meshing/ImproveDihedral.h"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>
#include <vector>

namespace kerf {
namespace {

class Improver {
 public:
  Improver(const DihedralOptions& options, TetMesh* mesh)
      : options_(options), mesh_(*mesh), start_(mesh->rest), tets_of_(mesh->VertexCount()) {
    for (Index t = 0; t < mesh_.TetCount(); ++t)
      for (int k = 0; k < 4; ++k) tets_of_[mesh_.tets(t, k)].push_back(t);
    FindFreedom();
    for (const Vec3& d :
         {Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1), Vec3(1, 1, 0), Vec3(1, -1, 0), Vec3(1, 0, 1),
          Vec3(1, 0, -1), Vec3(0, 1, 1), Vec3(0, 1, -1), Vec3(1, 1, 1), Vec3(1, 1, -1),
          Vec3(1, -1, 1), Vec3(-1, 1, 1)}) {
      directions_.push_back(d.normalized());
      directions_.push_back(-d.normalized());
    }
  }

  double Run() {
    for (int sweep = 0; sweep < 40; ++sweep) {
      std::vector<std::pair<double, Index>> bad;
      for (Index t = 0; t < mesh_.TetCount(); ++t) {
        const double angle = Angle(t);
        if (angle < options_.wanted_deg) bad.push_back({angle, t});
      }
      std::sort(bad.begin(), bad.end());
      bool moved = false;
      for (const auto& [angle, t] : bad)
        for (int k = 0; k < 4; ++k) moved = Move(mesh_.tets(t, k)) || moved;
      if (!moved) break;
    }
    double smallest = 180.0;
    for (Index t = 0; t < mesh_.TetCount(); ++t) smallest = std::min(smallest, Angle(t));
    return smallest;
  }

 private:
  double Angle(Index t) const {
    std::array<Vec3, 4> x;
    for (int k = 0; k < 4; ++k) x[k] = mesh_.rest.row(mesh_.tets(t, k)).transpose();
    return SmallestDihedral_deg(x[0], x[1], x[2], x[3]);
  }
  double SmallestAround(Index v) const {
    double smallest = 180.0;
    for (Index t : tets_of_[v]) smallest = std::min(smallest, Angle(t));
    return smallest;
  }

  void FindFreedom() {
    freedom_.assign(mesh_.VertexCount(), std::numeric_limits<double>::infinity());
    for (Index v = 0; v < mesh_.VertexCount(); ++v)
      for (Index t : tets_of_[v])
        if (mesh_.region[t] != mesh_.region[tets_of_[v][0]])
          freedom_[v] = options_.interface_shift_mm;
    const Triangles boundary = BoundaryFaces(mesh_.tets);
    for (Index f = 0; f < boundary.rows(); ++f)
      for (int k = 0; k < 3; ++k)
        freedom_[boundary(f, k)] = std::min(freedom_[boundary(f, k)], options_.boundary_shift_mm);
  }

  /// Pattern search with shrinking steps. @return whether the vertex moved
  bool Move(Index v) {
    if (freedom_[v] <= 0.0) return false;
    double best = SmallestAround(v);
    if (best >= options_.wanted_deg) return false;
    double edge = std::numeric_limits<double>::infinity();
    for (Index t : tets_of_[v])
      for (int k = 0; k < 4; ++k)
        if (mesh_.tets(t, k) != v)
          edge = std::min(edge, (mesh_.rest.row(mesh_.tets(t, k)) - mesh_.rest.row(v)).norm());
    bool moved = false;
    for (double step = std::min(0.3 * edge, freedom_[v]); step > 0.01 * edge; step *= 0.6) {
      const Vec3 from = mesh_.rest.row(v).transpose();
      Vec3 to = from;
      for (const Vec3& direction : directions_) {
        const Vec3 candidate = from + step * direction;
        if ((candidate - start_.row(v).transpose()).norm() > freedom_[v]) continue;
        mesh_.rest.row(v) = candidate.transpose();
        const double angle = SmallestAround(v);
        if (angle > best + 1e-6) {
          best = angle;
          to = candidate;
          moved = true;
        }
      }
      mesh_.rest.row(v) = to.transpose();
    }
    return moved;
  }

  const DihedralOptions options_;
  TetMesh& mesh_;
  const Points start_;
  std::vector<std::vector<Index>> tets_of_;
  std::vector<double> freedom_;
  std::vector<Vec3> directions_;
};

}  // namespace

double ImproveDihedral(const DihedralOptions& options, TetMesh* mesh) {
  return Improver(options, mesh).Run();
}

}  // namespace kerf
