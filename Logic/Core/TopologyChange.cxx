#include "Core/TopologyChange.h"

#include <algorithm>
#include <limits>

namespace kerf {
namespace {

constexpr double kInside = -1e-9;  // barycentric slack

/// The patch of a change, prepared for finding the new tetrahedron of old material points.
class PatchSearch {
 public:
  PatchSearch(const TopologyChange& change, const TetMesh& old_mesh)
      : change_(change), old_mesh_(old_mesh) {
    const Index n = static_cast<Index>(change.new_tets.size());
    low_.resize(n, 3);
    high_.resize(n, 3);
    for (Index i = 0; i < n; ++i) {
      const auto corners = change.mesh.tets.row(change.new_tets[i]);
      low_.row(i) = high_.row(i) = change.mesh.rest.row(corners[0]);
      for (int k = 1; k < 4; ++k) {
        low_.row(i) = low_.row(i).cwiseMin(change.mesh.rest.row(corners[k]));
        high_.row(i) = high_.row(i).cwiseMax(change.mesh.rest.row(corners[k]));
      }
      child_.push_back({change.parent_tet[change.new_tets[i]], change.new_tets[i]});
    }
    std::sort(child_.begin(), child_.end());
  }

  Index Find(Index old_tet, const Vec3& p, Vec4* weights) const {
    Best best;
    for (auto it =
             std::lower_bound(child_.begin(), child_.end(), std::make_pair(old_tet, Index(-1)));
         it != child_.end() && it->first == old_tet; ++it)
      Visit(it->second, old_tet, p, &best);
    if (best.tet < 0 || best.inside < kInside) {
      const Eigen::RowVector3d at = p.transpose();
      const Eigen::RowVector3d slack = Eigen::RowVector3d::Constant(1e-6);
      for (Index i = 0; i < low_.rows(); ++i)
        if (((at + slack).array() >= low_.row(i).array()).all() &&
            ((at - slack).array() <= high_.row(i).array()).all())
          Visit(change_.new_tets[i], old_tet, p, &best);
    }
    if (best.tet < 0 || best.inside < kInside)  // outside the organ: bound from the same side
      for (Index t : change_.new_tets)
        if (SharedCorners(t, old_tet) > 0) Visit(t, old_tet, p, &best);
    *weights = best.weights;
    return best.tet;
  }

 private:
  struct Best {
    Index tet = -1;
    double inside = -std::numeric_limits<double>::infinity();
    int shared = -1;
    Vec4 weights = Vec4::Zero();
  };

  /// Corners that stem from corners of the old tetrahedron: tells the two sides of an old crack
  /// apart.
  int SharedCorners(Index t, Index old_tet) const {
    int shared = 0;
    for (int k = 0; k < 4; ++k) {
      const Index v = change_.mesh.tets(t, k);
      for (int j = 0; j < 4; ++j)
        if (change_.vertex_weights(v, j) > 1e-9)
          for (int i = 0; i < 4; ++i)
            shared += change_.vertex_parents[v][j] == old_mesh_.tets(old_tet, i);
    }
    return shared;
  }

  void Visit(Index t, Index old_tet, const Vec3& p, Best* best) const {
    const auto c = change_.mesh.tets.row(t);
    const Points& x = change_.mesh.rest;
    const Vec4 w = BarycentricWeights(p, x.row(c[0]).transpose(), x.row(c[1]).transpose(),
                                      x.row(c[2]).transpose(), x.row(c[3]).transpose());
    const double inside = std::min(w.minCoeff(), kInside);  // all that hold p are equal
    if (best->tet >= 0 && inside < best->inside) return;
    const int shared = SharedCorners(t, old_tet);
    if (best->tet >= 0 && inside == best->inside && shared <= best->shared) return;
    *best = {t, inside, shared, w};
  }

  const TopologyChange& change_;
  const TetMesh& old_mesh_;
  Points low_, high_;                           // boxes of new_tets
  std::vector<std::pair<Index, Index>> child_;  // (old tet, new tet), ascending
};

}  // namespace

Points TopologyChange::MapVertexField(const Points& old_field) const {
  Points out(mesh.VertexCount(), 3);
  for (Index v = 0; v < mesh.VertexCount(); ++v) {
    if (vertex_weights(v, 0) == 1.0 && (vertex_weights.row(v).rightCols<3>().array() == 0).all()) {
      out.row(v) = old_field.row(vertex_parents[v][0]);
      continue;
    }
    out.row(v).setZero();
    for (int k = 0; k < 4; ++k)
      if (vertex_weights(v, k) != 0.0)
        out.row(v) += vertex_weights(v, k) * old_field.row(vertex_parents[v][k]);
  }
  return out;
}

Embedding TopologyChange::MapEmbedding(const Embedding& old, const TetMesh& old_mesh) const {
  Embedding out = old;
  if (!changed) return out;
  const PatchSearch search(*this, old_mesh);
  for (Index i = 0; i < old.Size(); ++i) {
    const Index kept = kept_tet[old.tet[i]];
    if (kept >= 0) {
      out.tet[i] = kept;
      continue;
    }
    const auto corners = old_mesh.tets.row(old.tet[i]);
    Vec3 p = Vec3::Zero();
    for (int k = 0; k < 4; ++k) p += old.weights(i, k) * old_mesh.rest.row(corners[k]).transpose();
    Vec4 weights;
    out.tet[i] = search.Find(old.tet[i], p, &weights);
    out.weights.row(i) = weights.transpose();
  }
  return out;
}

}  // namespace kerf
