#pragma once

#include <functional>
#include <string>
#include <vector>

#include "Core/Progress.h"
#include "Core/Volume.h"

namespace kerf::testing {

/// Keeps warnings.
class RecordedProgress : public Progress {
 public:
  void Warn(const std::string& message) override { warnings.push_back(message); }
  bool IsCancelled() const override { return cancelled; }
  bool Warned(const std::string& part) const {
    for (const auto& w : warnings)
      if (w.find(part) != std::string::npos) return true;
    return false;
  }
  std::vector<std::string> warnings;
  bool cancelled = false;
};

/// Labels of a formula over world coordinates relative to the grid's centre, on an oblique
/// anisotropic grid whose centre is at (30, −20, 100).
inline LabelMap LabelsOf(const std::function<Label(const Vec3&)>& label, int size = 44,
                         const Vec3& spacing = {1.0, 1.1, 1.3}, bool left_handed = false) {
  LabelMap labels;
  labels.source = "made-up.nii.gz";
  labels.grid.size = Eigen::Vector3i::Constant(size);
  labels.grid.spacing_mm = spacing;
  labels.grid.direction =
      (Eigen::AngleAxisd(0.4, Vec3::UnitZ()) * Eigen::AngleAxisd(-0.3, Vec3::UnitX()))
          .toRotationMatrix();
  if (left_handed) labels.grid.direction.col(2) *= -1.0;
  const Vec3 center(30, -20, 100);
  labels.grid.origin_mm =
      center - labels.grid.direction * (0.5 * (size - 1) * labels.grid.spacing_mm);
  auto voxels = std::make_shared<std::vector<std::uint8_t>>(labels.grid.VoxelCount());
  for (int k = 0; k < size; ++k)
    for (int j = 0; j < size; ++j)
      for (int i = 0; i < size; ++i)
        (*voxels)[labels.grid.Offset(i, j, k)] =
            static_cast<std::uint8_t>(label(labels.grid.WorldFromIndex(Vec3(i, j, k)) - center));
  labels.voxels = voxels;
  return labels;
}

/// Ellipsoid of half axes 18, 15, 13 mm with a tumour of radius 4.5 mm inside and a tube.
inline Label OrganWithTumour(const Vec3& x) {
  if (x.cwiseQuotient(Vec3(18, 15, 13)).norm() > 1.0) return Label::Background;
  if ((x - Vec3(6, 3, 0)).norm() < 4.5) return Label::Tumour;
  if (std::abs(x.y()) < 30 && Vec3(x.x() + 6, 0, x.z()).norm() < 2.0 && std::abs(x.y()) < 8)
    return Label::Internal;
  return Label::Organ;
}

}  // namespace kerf::testing
