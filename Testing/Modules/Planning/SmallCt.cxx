#include "SmallCt.h"

#include <cmath>
#include <random>

namespace kerf::testing {

Volume EllipsoidCt(const Eigen::Vector3i& size, const Vec3& spacing_mm, double scale) {
  Volume ct;
  ct.grid.size = size;
  ct.grid.spacing_mm = spacing_mm;
  ct.grid.origin_mm = -0.5 * (size.cast<double>() - Vec3::Ones()).cwiseProduct(spacing_mm);
  ct.source = "small ct";
  auto voxels = std::make_shared<std::vector<std::int16_t>>(ct.grid.VoxelCount());
  std::mt19937 random(7);
  std::size_t at = 0;
  for (int k = 0; k < size[2]; ++k)
    for (int j = 0; j < size[1]; ++j)
      for (int i = 0; i < size[0]; ++i, ++at) {
        const Vec3 p = ct.grid.WorldFromIndex(Vec3(i, j, k)) / scale;
        const double organ = p.cwiseQuotient(Vec3(36, 24, 22)).norm();
        double hu = j < 2 ? -1000 : -100;
        if (organ < 1) hu = 165;
        if ((p - Vec3(16, -8, 2)).norm() < 7) hu = 80;
        if (std::hypot(p[1] - 3, p[2] + 1) < 4 && p[0] > -22 && p[0] < 2) hu = 400;
        // Sum of uniforms: the same on every platform, unlike std::normal_distribution.
        double noise = -6;
        for (int n = 0; n < 12; ++n) noise += random() / 4294967296.0;
        (*voxels)[at] = static_cast<std::int16_t>(std::lround(hu + 4 * noise));
      }
  ct.voxels = std::move(voxels);
  return ct;
}

Volume SmallCt() { return EllipsoidCt({52, 40, 38}, Vec3::Constant(2), 1); }

}  // namespace kerf::testing
