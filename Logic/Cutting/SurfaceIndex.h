#pragma once

#include <array>
#include <vector>

#include "Core/TopologyChange.h"

namespace kerf {

/// Where a point stands to a separation surface.
struct SurfaceNear {
  double distance_mm = 1e300;
  Vec3 point = Vec3::Zero();    ///< closest point of S
  Vec3 normal = Vec3::UnitZ();  ///< of the triangle there
  int triangle = -1;            ///< row in the surface; −1: nothing within the asked distance
  bool on_border = false;       ///< the closest point lies on S's border
};

/// One number for points with equal coordinates: that of the first of them. Finite coordinates
/// only.
std::vector<Index> EqualPoints(const Points& points);

/// Bounding-volume tree over a separation surface: closest points, crossings of segments, boxes.
/// Points with equal coordinates count as one, so that surfaces read from files know their border.
/// Immutable.
class SurfaceIndex {
 public:
  explicit SurfaceIndex(const CutSurface& surface);
  bool Empty() const { return triangles_.empty(); }

  SurfaceNear Closest(const Vec3& p, double max_distance_mm) const;
  /// Does S end within this distance?
  bool BorderWithin(const Vec3& p, double distance_mm) const;
  /// Parameters 0 ≤ t ≤ 1 along a–b where S crosses the segment, ascending, equal ones merged. All
  /// with `from` ≤ t ≤ `to` are found, others perhaps.
  void Crossings(const Vec3& a, const Vec3& b, std::vector<double>* t, double from = 0,
                 double to = 1) const;
  /// Does S come into this box? By boxes and planes of triangles: sometimes yes where it just
  /// misses, never no where it comes in.
  bool MeetsBox(const Vec3& low, const Vec3& high) const;

 private:
  struct Node {
    Vec3 low, high;
    Vec3 normal;                ///< of one of its triangles
    double back, front;         ///< all of its points lie between, along `normal`
    int left = -1, right = -1;  ///< children; leaf: triangles_[first .. first+count)
    int first = 0, count = 0;
  };
  struct Place {
    Vec3 center;  ///< times three
    int triangle;
  };
  int Build(int first, int count, std::vector<Place>* places);
  void CloseTo(int node, const Vec3& p, SurfaceNear* best) const;

  struct Triangle {
    std::array<Vec3, 3> x;
    Vec3 normal;
    int row;
    std::array<bool, 3> border;  ///< edge k from corner k to corner k+1
  };
  std::vector<Triangle> triangles_;  ///< in the order of the leaves
  std::vector<Node> nodes_;
};

}  // namespace kerf
