#pragma once

#include <vector>

#include "Cutting/CutPatch.h"

namespace kerf {

/// Where a boundary vertex may go without changing the organ: its allowed directions keep the
/// volume exactly, its distance from the planes of the faces around it stays within a tolerance.
class BoundarySlide {
 public:
  BoundarySlide(const CutPatch& patch, int v, double tolerance_mm);
  bool OnBoundary() const { return !normals_.empty(); }
  /// Allowed displacement along which `wish` is reached: the component of the way to S along `wish`
  /// is kept. False where sliding cannot follow it.
  bool Toward(const Vec3& wish, Vec3* displacement) const;
  /// The allowed part of a displacement (for smoothing).
  Vec3 Project(const Vec3& displacement) const;
  bool Allowed(const Vec3& displacement) const;
  /// All faces within `angle_deg` of being parallel to a plane with this normal.
  bool ParallelTo(const Vec3& normal, double angle_deg) const;

 private:
  std::vector<Vec3> normals_;
  double tolerance_mm_;
  Mat3 plane_ = Mat3::Identity();  ///< projection that keeps the volume
  Vec3 crease_ = Vec3::Zero();     ///< direction that stays on all faces best
};

}  // namespace kerf
