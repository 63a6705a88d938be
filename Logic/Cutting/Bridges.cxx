#include "Cutting/Bridges.h"

#include <algorithm>
#include <array>
#include <vector>

#include "Cutting/CutRegion.h"
#include "Cutting/SurfaceIndex.h"

namespace kerf {
namespace {

// In mean edges.
constexpr double kZone = 1.5;   // tetrahedra this near to S may lead across
constexpr double kClear = 0.4;  // and from here on lie clearly on one side
constexpr double kFront = 1.5;  // the crack front is this near to the end of S

}  // namespace

bool JoinedAcross(const TetMesh& mesh, const CutSurface& surface) {
  const SurfaceIndex index(surface);
  if (index.Empty()) return false;
  const double edge_mm = MeanEdge_mm(mesh);
  CutBox zone;
  for (Index i = 0; i < surface.points.rows(); ++i) zone.Add(surface.points.row(i));
  zone.Grow(kZone * edge_mm);
  struct Near {
    Index tet;
    int side;  // −1, 1; 0: not clear
  };
  std::vector<Near> near;
  for (Index t = 0; t < mesh.TetCount(); ++t) {
    Vec3 middle = Vec3::Zero();
    for (int k = 0; k < 4; ++k) middle += mesh.rest.row(mesh.tets(t, k)).transpose() / 4;
    if ((middle.transpose().array() < zone.low.array()).any() ||
        (middle.transpose().array() > zone.high.array()).any())
      continue;
    const SurfaceNear at = index.Closest(middle, kZone * edge_mm);
    if (at.triangle < 0 || index.BorderWithin(at.point, kFront * edge_mm)) continue;
    const double off = (middle - at.point).dot(at.normal) / edge_mm;
    near.push_back({t, off > kClear ? 1 : off < -kClear ? -1 : 0});
  }
  struct Side {
    std::array<Index, 3> face;
    int of;
  };
  std::vector<Side> sides;
  for (std::size_t i = 0; i < near.size(); ++i)
    for (int k = 0; k < 4; ++k) {
      Side side{{}, static_cast<int>(i)};
      for (int c = 0, n = 0; c < 4; ++c)
        if (c != k) side.face[n++] = mesh.tets(near[i].tet, c);
      std::sort(side.face.begin(), side.face.end());
      sides.push_back(side);
    }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    return a.face != b.face ? a.face < b.face : a.of < b.of;
  });
  std::vector<std::vector<int>> beside(near.size());
  for (std::size_t i = 0; i + 1 < sides.size(); ++i)
    if (sides[i].face == sides[i + 1].face) {
      beside[sides[i].of].push_back(sides[i + 1].of);
      beside[sides[i + 1].of].push_back(sides[i].of);
    }
  // From all tetrahedra behind S: is one in front of it reached?
  std::vector<int> reached;
  std::vector<char> seen(near.size(), 0);
  for (std::size_t i = 0; i < near.size(); ++i)
    if (near[i].side < 0) {
      reached.push_back(static_cast<int>(i));
      seen[i] = 1;
    }
  for (std::size_t i = 0; i < reached.size(); ++i)
    for (int next : beside[reached[i]]) {
      if (near[next].side > 0) return true;
      if (!seen[next]) reached.push_back(next);
      seen[next] = 1;
    }
  return false;
}

}  // namespace kerf
