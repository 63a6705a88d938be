#include "Registration/CutPolygon.h"

#include <algorithm>

namespace kerf {
namespace {

constexpr double kShortestStep_mm = 1.0;

/// Appends `point` where it lies beyond the end of `line` (direction of growth).
bool AppendBeyond(std::vector<Vec3>* line, const Vec3& point, const Vec3& direction) {
  if (direction.dot(point - line->back()) <= kShortestStep_mm) return false;
  line->push_back(point);
  return true;
}

}  // namespace

bool CutPolygon::Insert(const Vec3& point, double radius_mm) {
  if (inserted_.empty()) {
    inserted_.push_back(point);
    return false;
  }
  const bool at_front = inserted_.size() > 1 &&
                        (point - inserted_.front()).norm() < (point - inserted_.back()).norm();
  if (at_front) {
    std::reverse(inserted_.begin(), inserted_.end());
    std::reverse(committed_.begin(), committed_.end());
  }
  const Vec3 last = inserted_.back();
  const Vec3 direction = (point - last).normalized();
  inserted_.push_back(point);
  bool grew = false;
  if ((point - last).norm() > 1e-6) {
    if (committed_.empty()) {
      committed_ = {last - radius_mm * direction, last};
      grew = true;
    }
    grew |= AppendBeyond(&committed_, point, direction);
    grew |= AppendBeyond(&committed_, point + radius_mm * direction, direction);
  }
  if (at_front) {
    std::reverse(inserted_.begin(), inserted_.end());
    std::reverse(committed_.begin(), committed_.end());
  }
  return grew;
}

CutPolyline CutPolygon::Committed() const {
  CutPolyline line;
  line.points.resize(committed_.size(), 3);
  for (std::size_t i = 0; i < committed_.size(); ++i)
    line.points.row(i) = committed_[i].transpose();
  return line;
}

}  // namespace kerf
