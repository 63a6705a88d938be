#include "Phantom/PhantomShape.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace kerf {
namespace {

double SmoothMin(double a, double b, double k) {
  const double h = std::max(k - std::abs(a - b), 0.0) / k;
  return std::min(a, b) - 0.25 * h * h * k;
}

/// Ellipsoid, scaled to a first-order distance.
double Ellipsoid(const Vec3& p, const Vec3& radii) {
  const double k0 = p.cwiseQuotient(radii).norm();
  const double k1 = p.cwiseQuotient(radii.cwiseProduct(radii)).norm();
  return k1 < 1e-9 ? -radii.minCoeff() : k0 * (k0 - 1.0) / k1;
}

double Capsule(const Vec3& p, const Vec3& a, const Vec3& b, double radius_a, double radius_b) {
  const Vec3 ab = b - a;
  const double t = std::clamp((p - a).dot(ab) / ab.squaredNorm(), 0.0, 1.0);
  return (p - a - t * ab).norm() - (radius_a + t * (radius_b - radius_a));
}

const Vec3 kTumourCentre(27.0, -15.5, 13.0);
constexpr double kTumourRadius_mm = 7.5;

double KidneyBody(const Vec3& p) {
  // The axis bends towards the hilum; the lower pole is a little slimmer than the upper one.
  const double t = p.x() / 50.0;
  const Vec3 q(p.x(), p.y() - 8.0 * t * t + 2.0, p.z() + 1.5 * t);
  const double slim = 1.0 + 0.06 * t;
  double f = Ellipsoid(q, Vec3(51.0, 26.0 * slim, 22.0 * slim));
  // Shallow lobulation, as many kidneys keep from childhood.
  f += 0.55 * std::sin(0.155 * p.x() + 0.6) * std::sin(0.16 * p.y() + 0.9) +
       0.45 * std::sin(0.21 * p.x() - 0.8) * std::cos(0.17 * p.z());
  const double hilum = Ellipsoid(p - Vec3(1.0, 33.0, 0.0), Vec3(19.0, 12.5, 12.0));
  return -SmoothMin(-f, hilum, 9.0);
}

}  // namespace

double KidneyTumour(const Vec3& p) {
  const Vec3 q = p - kTumourCentre;
  const Vec3 n = q / std::max(q.norm(), 1e-9);
  const double uneven = 0.35 * std::sin(3.0 * n.x() + 1.0) * std::sin(3.4 * n.y()) +
                        0.25 * std::cos(4.0 * n.z() + 2.0 * n.x());
  return q.norm() - kTumourRadius_mm - uneven * std::min(q.norm() / kTumourRadius_mm, 1.0);
}

double KidneyOrgan(const Vec3& p) { return SmoothMin(KidneyBody(p), KidneyTumour(p) - 0.4, 4.0); }

double KidneyCalyces(const Vec3& p) {
  struct Tube {
    Vec3 a, b;
    double radius_a, radius_b;
  };
  // Infundibula from the pelvis, then the minor calyces that end in cups.
  static const std::array<Tube, 9> tubes{{
      {{3, 9, 0}, {17, 3, 1}, 3.0, 2.1},
      {{3, 9, 0}, {-17, 4, -1}, 3.0, 2.1},
      {{3, 9, 0}, {2, -2, 1}, 2.8, 2.0},
      {{17, 3, 1}, {26, 5, 2}, 2.0, 1.9},
      {{17, 3, 1}, {21, -6, -2}, 2.0, 1.9},
      {{-17, 4, -1}, {-26, 6, 0}, 2.0, 1.9},
      {{-17, 4, -1}, {-19, -6, 2}, 2.0, 1.9},
      {{2, -2, 1}, {-5, -10, 2}, 1.9, 1.8},
      {{2, -2, 1}, {9, -10, -2}, 1.9, 1.8},
  }};
  double f = Ellipsoid(p - Vec3(3, 10, 0), Vec3(9.0, 5.5, 5.0));
  for (std::size_t i = 0; i < tubes.size(); ++i) {
    const Tube& tube = tubes[i];
    f = SmoothMin(f, Capsule(p, tube.a, tube.b, tube.radius_a, tube.radius_b), 2.0);
    if (i >= 3) f = SmoothMin(f, (p - tube.b).norm() - 3.3, 1.5);
  }
  return f;
}

double KidneyEntryY_mm(double sheet_x_mm) {
  // Lowest y of the section: golden-section search over z around a bisection in y.
  auto border = [&](double z) {
    double outside = -60.0, inside = 0.0;
    for (int i = 0; i < 60; ++i) {
      const double y = 0.5 * (outside + inside);
      (KidneyOrgan({sheet_x_mm, y, z}) > 0 ? outside : inside) = y;
    }
    return 0.5 * (outside + inside);
  };
  double low = -12.0, high = 12.0;
  const double golden = 0.5 * (std::sqrt(5.0) - 1.0);
  for (int i = 0; i < 60; ++i) {
    const double a = high - golden * (high - low), b = low + golden * (high - low);
    if (border(a) < border(b))
      high = b;
    else
      low = a;
  }
  return border(0.5 * (low + high));
}

}  // namespace kerf
