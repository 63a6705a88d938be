#include "Cutting/BoundarySlide.h"

#include <cmath>

namespace kerf {

BoundarySlide::BoundarySlide(const CutPatch& patch, int v, double tolerance_mm)
    : tolerance_mm_(tolerance_mm) {
  std::vector<CutPatch::FanFace> fan;
  patch.BoundaryFan(v, &fan);
  if (fan.empty()) return;
  const Vec3 x = patch.vertices[v].rest;
  Vec3 area = Vec3::Zero();
  Mat3 spread = Mat3::Zero();
  double total = 0;
  for (const auto& [a, b] : fan) {
    const Vec3 n = (patch.vertices[a].rest - x).cross(patch.vertices[b].rest - x);
    const double length = n.norm();
    area += n;
    total += length;
    if (length > 0) {
      normals_.push_back(n / length);
      spread += n * n.transpose() / length;
    }
  }
  // The volume is linear in x with gradient area/6: moving in the plane orthogonal to `area` keeps
  // it exactly. The two sides of a crack cancel: its front may go anywhere.
  if (area.norm() > 1e-6 * total) {
    const Vec3 n = area.normalized();
    plane_ -= n * n.transpose();
    spread = plane_ * spread * plane_ + 1e3 * total * n * n.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Mat3> eigen(spread);
  crease_ = (plane_ * eigen.eigenvectors().col(0)).normalized();
}

bool BoundarySlide::Allowed(const Vec3& d) const {
  for (const Vec3& n : normals_)
    if (std::abs(n.dot(d)) > tolerance_mm_) return false;
  return true;
}

bool BoundarySlide::Toward(const Vec3& wish, Vec3* displacement) const {
  constexpr double kSteepest = 0.35;  // sine of the smallest angle between way and S
  const double length = wish.norm();
  const Vec3 way = wish / length, in_plane = plane_ * way;
  if (in_plane.norm() > kSteepest) {
    *displacement = in_plane * (length / in_plane.squaredNorm());
    if (Allowed(*displacement)) return true;
  }
  const double along = crease_.dot(way);
  if (std::abs(along) < kSteepest) return false;
  *displacement = crease_ * (length / along);
  return Allowed(*displacement);
}

Vec3 BoundarySlide::Project(const Vec3& displacement) const {
  const Vec3 in_plane = plane_ * displacement;
  return Allowed(in_plane) ? in_plane : Vec3(crease_ * crease_.dot(displacement));
}

bool BoundarySlide::ParallelTo(const Vec3& normal, double angle_deg) const {
  const double cosine = std::cos(angle_deg * M_PI / 180);
  for (const Vec3& n : normals_)
    if (std::abs(n.dot(normal)) < cosine) return false;
  return true;
}

}  // namespace kerf
