#pragma once

#include <memory>
#include <optional>

#include "Core/Camera.h"
#include "Core/SurfaceMesh.h"

namespace kerf {

struct SurfaceHit {
  Index triangle = -1;
  Vec3 point = Vec3::Zero();    ///< on the triangle, mm
  Vec3 weights = Vec3::Zero();  ///< barycentric in the triangle
  double distance_mm = 0.0;     ///< from the ray's origin, or from the query point
};

/// AABB tree over a triangle surface: ray casts, closest points, inside tests. Immutable; safe for
/// concurrent queries.
class SurfaceTree {
 public:
  explicit SurfaceTree(const SurfaceMesh& surface);
  ~SurfaceTree();
  SurfaceTree(SurfaceTree&&) noexcept;
  SurfaceTree& operator=(SurfaceTree&&) noexcept;

  /// First hit along the ray, none where it misses.
  std::optional<SurfaceHit> FirstHit(const Ray& ray) const;
  /// Whether FirstHit finds something, in less time.
  bool IsHit(const Ray& ray) const;
  /// Closest surface point. The surface must not be empty.
  SurfaceHit Closest(const Vec3& p) const;
  /// For closed surfaces: is p inside (ray parity, robust)?
  bool Inside(const Vec3& p) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace kerf
