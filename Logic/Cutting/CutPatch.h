#pragma once

#include <array>
#include <vector>

#include "Core/TopologyChange.h"
#include "Cutting/EdgeKey.h"
#include "Cutting/ShortLists.h"

namespace kerf {

/// Corners of the face opposite to each corner, counter-clockwise seen from outside.
inline constexpr int kFaces[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};

/// The part of a tetra mesh that a cut may change, in numbers of its own: small enough to copy, try
/// and throw away. Frozen vertices have tetrahedra outside the patch and stay as they are.
class CutPatch {
 public:
  struct Vertex {
    Vec3 rest, current;
    Index old_vertex = -1;  ///< in the whole mesh; −1: made by the cut
    bool frozen = false;
    bool moved = false;
    bool on = false;     ///< counts as lying on S
    bool core = false;   ///< corner of a tetrahedron that S crosses
    double size_mm = 0;  ///< mean length of its edges when the patch was made
  };
  struct Tet {
    std::array<int, 4> v;
    int source = -1;  ///< patch tetrahedron (before the cut) that it was cut out of
    std::uint8_t region = 1;
    bool changed = false;
    std::uint8_t opened = 0;  ///< bit k: this cut opened the face opposite to corner k
  };
  /// A face at a vertex, by the edge opposite to it.
  struct FaceAt {
    std::uint64_t edge;
    std::array<int, 2> ends;  ///< of the edge, counter-clockwise seen from outside `tet`
    int tet, other;           ///< on its two sides, places in `star`; other −1: boundary
  };
  /// A boundary triangle at a vertex: the two other corners, seen counter-clockwise from outside.
  using FanFace = std::array<int, 2>;

  std::vector<Vertex> vertices;
  std::vector<Tet> tets;
  ShortLists star;             ///< vertex → its tetrahedra, in the order of their creation
  std::vector<Index> old_tet;  ///< of the first tetrahedra: index in the whole mesh
  bool deformed = false;       ///< `current` differs from `rest` and has to stay positive

  /// The tetrahedra `chosen` of the whole mesh. @param inner N: vertex has no tetrahedra outside
  /// the patch
  CutPatch(const TetMesh& mesh, const Points* positions, const std::vector<Index>& chosen,
           const std::vector<char>& inner);

  /// What these tetrahedra (numbers of the whole mesh, ascending) have become.
  std::vector<int> TetsOutOf(const std::vector<Index>& tets_of_mesh) const;
  /// Marks the corners of these tetrahedra, and no others.
  void MarkCore(const std::vector<int>& of_tets);

  /// Each face at v once.
  void FacesAt(int v, std::vector<FaceAt>* faces) const;
  /// Boundary triangles of the organ around an inner vertex.
  void BoundaryFan(int v, std::vector<FanFace>* fan) const;
  bool Has(int tet, int v) const {
    const auto& x = tets[tet].v;
    return x[0] == v || x[1] == v || x[2] == v || x[3] == v;
  }
  std::vector<int> Around(int a, int b) const;  ///< tetrahedra with the edge a–b
  std::vector<int> Neighbors(int v) const;      ///< vertices joined to v, ascending

  /// Cosine of the smallest dihedral angle: larger is worse; 2 when the volume is not positive.
  double WorstCosine(int tet) const;
  double WorstCosineCurrent(int tet) const;
  double WorstCosineAround(int v) const;
  double WorstCurrentAround(int v) const;

  double Volume_mm3(int tet) const;  ///< at rest

  /// Bisects all tetrahedra around a–b at `at`; returns the new vertex.
  int SplitEdge(int a, int b, const Vec3& at);

  /// Moves a vertex at rest, its current position with the material.
  void Move(int v, const Vec3& to, const CutPatch& before);

  /// Moves v if the tetrahedra around it stay good, at rest by this cosine and as deformed; puts
  /// everything back otherwise.
  bool TryMove(int v, const Vec3& to, double worst_allowed, const CutPatch& before);

  /// The tetrahedron of the patch before the cut that holds p, looked for around the sources of
  /// `near`; never across an earlier cut. Weights may be slightly negative at a moved boundary.
  int Locate(const Vec3& p, const std::vector<int>& near_sources, Vec4* weights) const;
  Vec3 CurrentOf(int tet, const Vec4& weights) const;
};

double CosineOf(double angle_deg);
double CosineOfSmallestDihedral(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);
/// Are all dihedral angles certainly above the one with this cosine? Cheaper than to compute them;
/// sometimes no where they only just are.
bool AllAnglesAbove(double cosine, const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);

}  // namespace kerf
