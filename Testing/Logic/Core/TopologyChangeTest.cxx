#include <gtest/gtest.h>

#include <numeric>

#include "Core/TopologyChange.h"
#include "Support/TestMeshes.h"

namespace kerf {
namespace {

/// The change that changes nothing.
TopologyChange Identity(const TetMesh& mesh) {
  TopologyChange change;
  change.mesh = mesh;
  const Index n = mesh.VertexCount();
  change.vertex_parents.resize(n);
  change.vertex_weights = Weights4::Zero(n, 4);
  for (Index v = 0; v < n; ++v) {
    change.vertex_parents[v] = {v, v, v, v};
    change.vertex_weights(v, 0) = 1.0;
  }
  change.parent_tet.resize(mesh.TetCount());
  std::iota(change.parent_tet.begin(), change.parent_tet.end(), 0);
  change.kept_tet = change.parent_tet;
  return change;
}

/// Splits tetrahedron `tet` at its centroid into four.
TopologyChange SplitAtCentroid(const TetMesh& mesh, Index tet) {
  TopologyChange change = Identity(mesh);
  const Index v = mesh.VertexCount(), t = mesh.TetCount();
  change.changed = true;
  change.mesh.rest.conservativeResize(v + 1, 3);
  change.vertex_weights.conservativeResize(v + 1, 4);
  change.vertex_weights.row(v).setConstant(0.25);
  const std::array<Index, 4> corners = {mesh.tets(tet, 0), mesh.tets(tet, 1), mesh.tets(tet, 2),
                                        mesh.tets(tet, 3)};
  change.vertex_parents.push_back(corners);
  change.mesh.rest.row(v).setZero();
  for (Index c : corners) change.mesh.rest.row(v) += 0.25 * mesh.rest.row(c);
  change.mesh.tets.conservativeResize(t + 3, 4);
  for (int k = 0; k < 4; ++k) {
    const Index at = k == 0 ? tet : t + k - 1;
    for (int j = 0; j < 4; ++j) change.mesh.tets(at, j) = j == k ? v : corners[j];
    change.new_tets.push_back(at);
    if (k > 0) {
      change.parent_tet.push_back(tet);
      change.mesh.region.push_back(mesh.region[tet]);
    }
  }
  change.kept_tet[tet] = -1;
  return change;
}

Embedding OnePointInEach(const TetMesh& mesh) {
  Embedding e;
  e.weights.resize(mesh.TetCount(), 4);
  for (Index t = 0; t < mesh.TetCount(); ++t) {
    e.tet.push_back(t);
    e.weights.row(t) << 0.1, 0.2, 0.3, 0.4;
  }
  return e;
}

TEST(TopologyChange, TheIdentityChangesNothing) {
  const TetMesh mesh = testing::BoxMesh({10, 10, 10}, 2, 2, 2);
  const TopologyChange change = Identity(mesh);
  EXPECT_EQ(change.MapVertexField(mesh.rest), mesh.rest);
  const Embedding old = OnePointInEach(mesh), mapped = change.MapEmbedding(old, mesh);
  EXPECT_EQ(mapped.tet, old.tet);
  EXPECT_EQ(mapped.weights, old.weights);
}

TEST(TopologyChange, ASplitTetrahedronKeepsItsMaterialPoints) {
  const TetMesh mesh = testing::BoxMesh({10, 10, 10}, 2, 2, 2);
  const Index tet = 11;
  const TopologyChange change = SplitAtCentroid(mesh, tet);
  ASSERT_NO_THROW(change.mesh.Validate("split"));
  const Embedding old = OnePointInEach(mesh), mapped = change.MapEmbedding(old, mesh);
  const Points before = old.Positions(mesh.rest, mesh.tets);
  const Points after = mapped.Positions(change.mesh.rest, change.mesh.tets);
  EXPECT_LT((before - after).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_GE(mapped.weights.row(tet).minCoeff(), -1e-9) << "the point is inside its new tetrahedron";
  EXPECT_NE(std::find(change.new_tets.begin(), change.new_tets.end(), mapped.tet[tet]),
            change.new_tets.end());
  // A field that is linear over each tetrahedron is carried over exactly.
  Points field = 2.0 * mesh.rest;
  const Points mapped_field = change.MapVertexField(field);
  EXPECT_LT((mapped_field - 2.0 * change.mesh.rest).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(TopologyChange, AWeightOfOneIsNotYetACopy) {
  const TetMesh mesh = testing::BoxMesh({10, 10, 10}, 2, 2, 2);
  TopologyChange change = Identity(mesh);
  const auto corners = mesh.tets.row(0);
  change.vertex_parents[0] = {corners[0], corners[1], corners[2], corners[3]};
  change.vertex_weights.row(0) << 1, 0.1, -0.1, 0;  // slid along the boundary
  const Eigen::RowVector3d place =
      mesh.rest.row(corners[0]) + 0.1 * (mesh.rest.row(corners[1]) - mesh.rest.row(corners[2]));
  EXPECT_LT((change.MapVertexField(mesh.rest).row(0) - place).norm(), 1e-12);
}

}  // namespace
}  // namespace kerf
