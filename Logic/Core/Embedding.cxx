#include "Core/Embedding.h"

namespace kerf {

void Embedding::Positions(const Points& positions, const Tets& tets, Points* out) const {
  out->resize(Size(), 3);
  for (Index i = 0; i < Size(); ++i) {
    const auto corner = tets.row(tet[i]);
    out->row(i) =
        weights(i, 0) * positions.row(corner[0]) + weights(i, 1) * positions.row(corner[1]) +
        weights(i, 2) * positions.row(corner[2]) + weights(i, 3) * positions.row(corner[3]);
  }
}

Points Embedding::Positions(const Points& positions, const Tets& tets) const {
  Points out;
  Positions(positions, tets, &out);
  return out;
}

Vec4 BarycentricWeights(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  Mat3 edges;
  edges << b - a, c - a, d - a;
  const Vec3 w = edges.inverse() * (p - a);
  return {1.0 - w.sum(), w[0], w[1], w[2]};
}

}  // namespace kerf
