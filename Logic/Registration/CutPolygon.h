#pragma once

#include <vector>

#include "Core/TopologyChange.h"
#include "Core/Types.h"

namespace kerf {

/// The paper's cut polygon: cut points as they were inserted, and the polygon that is cut along,
/// which reaches ahead by r_pC. What was cut stays cut: the committed polygon only grows at its
/// ends, it is never moved.
class CutPolygon {
 public:
  /// Inserts a cut point before the first or after the last one, whichever extremity is nearer, and
  /// extends the polygon there: to the point, then to the intersection of the line through the last
  /// two cut points with the sphere of radius r_pC around the new one ("Optimizations"). The first
  /// two points extend it at both ends, so that it reaches over the organ's boundary at the entry.
  /// @return true when the committed polygon grew
  bool Insert(const Vec3& point, double radius_mm);

  const std::vector<Vec3>& Inserted() const { return inserted_; }
  /// Empty before the second cut point (no direction yet).
  CutPolyline Committed() const;

 private:
  std::vector<Vec3> inserted_;   ///< p_C in order along the cut, at rest, mm
  std::vector<Vec3> committed_;  ///< what is cut along
};

}  // namespace kerf
