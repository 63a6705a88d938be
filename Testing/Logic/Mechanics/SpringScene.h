#pragma once

#include <cmath>
#include <random>

#include "Core/TetMesh.h"
#include "Mechanics/ElasticSolver.h"
#include "Support/TestMeshes.h"

namespace kerf::testing {

/// Kidney-sized ellipsoid, 102 × 55 × 27 mm; 20·n³ tetrahedra.
inline TetMesh Kidney(int n) { return EllipsoidMesh({51.0, 27.5, 13.5}, n); }

/// Material of the benchmarks: E = 10 kPa, ν = 0.45.
inline Material SoftTissue(double poisson = 0.45) {
  Material material;
  material.young_kPa = 10.0;
  material.poisson = poisson;
  return material;
}

/// At most `count` features at boundary vertices with z > 0, springs of k g/s² each to their rest
/// positions.
inline Springs SurfaceSprings(const TetMesh& mesh, int count, double k) {
  std::vector<Index> tet_of_vertex(mesh.VertexCount(), -1);
  std::vector<int> corner_of_vertex(mesh.VertexCount(), 0);
  for (Index t = 0; t < mesh.TetCount(); ++t)
    for (int a = 0; a < 4; ++a) {
      tet_of_vertex[mesh.tets(t, a)] = t;
      corner_of_vertex[mesh.tets(t, a)] = a;
    }
  std::vector<Index> vertices;
  BoundarySurface(mesh, mesh.rest, &vertices);
  std::vector<Index> front;
  for (Index v : vertices)
    if (mesh.rest(v, 2) > 0.0) front.push_back(v);
  const Index n = std::min<Index>(count, static_cast<Index>(front.size()));
  Springs springs;
  springs.at.tet.resize(n);
  springs.at.weights = Weights4::Zero(n, 4);
  springs.targets.resize(n, 3);
  springs.stiffness = Eigen::VectorXd::Constant(n, k);
  for (Index l = 0; l < n; ++l) {
    const Index v = front[static_cast<std::size_t>(l) * front.size() / n];
    springs.at.tet[l] = tet_of_vertex[v];
    springs.at.weights(l, corner_of_vertex[v]) = 1.0;
    springs.targets.row(l) = mesh.rest.row(v);
  }
  return springs;
}

/// The moving target of the benchmarks at `progress` in [0, 1]: 15° about y, 10 % longer along x, 5
/// mm along x and z.
inline Vec3 MovedPoint(const Vec3& rest, double progress) {
  const double angle = progress * 15.0 * M_PI / 180.0;
  const Vec3 stretched(rest.x() * (1.0 + 0.1 * progress), rest.y(), rest.z());
  return Eigen::AngleAxisd(angle, Vec3::UnitY()) * stretched +
         progress * 5.0 * Vec3(1, 0, 1).normalized();
}

/// Targets of all springs moved as MovedPoint moves their rest positions.
inline void MoveTargets(const TetMesh& mesh, double progress, Springs* springs) {
  const Points rest = springs->at.Positions(mesh.rest, mesh.tets);
  for (Index l = 0; l < rest.rows(); ++l)
    springs->targets.row(l) = MovedPoint(rest.row(l).transpose(), progress).transpose();
}

inline double LargestDistance(const Points& a, const Points& b) {
  return std::sqrt((a - b).rowwise().squaredNorm().maxCoeff());
}

}  // namespace kerf::testing
