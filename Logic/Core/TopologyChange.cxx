#include "Core/TopologyChange.h"

#include <limits>
#include <map>

namespace kerf {

Points TopologyChange::MapVertexField(const Points& old_field) const {
  Points out(mesh.VertexCount(), 3);
  for (Index v = 0; v < mesh.VertexCount(); ++v) {
    out.row(v).setZero();
    for (int k = 0; k < 4; ++k)
      if (vertex_weights(v, k) != 0.0)
        out.row(v) += vertex_weights(v, k) * old_field.row(vertex_parents[v][k]);
  }
  return out;
}

Embedding TopologyChange::MapEmbedding(const Embedding& old, const TetMesh& old_mesh) const {
  Embedding out;
  out.tet.resize(old.Size());
  out.weights.resize(old.Size(), 4);
  std::map<Index, std::vector<Index>> children;  // old tet → patch tets cut out of it
  for (Index t : new_tets) children[parent_tet[t]].push_back(t);
  // The tetrahedron whose smallest weight is largest holds the point (or is nearest to it in
  // weight).
  auto best_of = [&](const std::vector<Index>& candidates, const Vec3& p, Index* best,
                     Vec4* best_weights) {
    double best_inside = -std::numeric_limits<double>::infinity();
    for (Index t : candidates) {
      const auto c = mesh.tets.row(t);
      const Vec4 w =
          BarycentricWeights(p, mesh.rest.row(c[0]).transpose(), mesh.rest.row(c[1]).transpose(),
                             mesh.rest.row(c[2]).transpose(), mesh.rest.row(c[3]).transpose());
      if (w.minCoeff() > best_inside) {
        best_inside = w.minCoeff();
        *best = t;
        *best_weights = w;
      }
    }
    return best_inside;
  };
  for (Index i = 0; i < old.Size(); ++i) {
    const Index kept = kept_tet[old.tet[i]];
    if (kept >= 0) {
      out.tet[i] = kept;
      out.weights.row(i) = old.weights.row(i);
      continue;
    }
    const auto corners = old_mesh.tets.row(old.tet[i]);
    Vec3 p = Vec3::Zero();
    for (int k = 0; k < 4; ++k) p += old.weights(i, k) * old_mesh.rest.row(corners[k]).transpose();
    Index best = -1;
    Vec4 weights = Vec4::Zero();
    double inside = -std::numeric_limits<double>::infinity();
    const auto own = children.find(old.tet[i]);
    if (own != children.end()) inside = best_of(own->second, p, &best, &weights);
    if (inside < -1e-9) {
      Index other = -1;
      Vec4 other_weights = Vec4::Zero();
      if (best_of(new_tets, p, &other, &other_weights) > inside) {
        best = other;
        weights = other_weights;
      }
    }
    out.tet[i] = best;
    out.weights.row(i) = weights.transpose();
  }
  return out;
}

}  // namespace kerf
