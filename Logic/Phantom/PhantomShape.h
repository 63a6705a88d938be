#pragma once

#include "Core/Types.h"

/// The kidney phantom as implicit functions in its own axes (mm): x long axis (upper pole +), y
/// across (convex border −, hilum +), z towards the camera. Negative inside; near a surface the
/// value is close to the distance in mm.
namespace kerf {

/// Kidney with the bulge of its exophytic tumour: what a surgeon sees as the organ.
double KidneyOrgan(const Vec3& p);
/// Tumour: a slightly uneven ball, inside KidneyOrgan.
double KidneyTumour(const Vec3& p);
/// Renal pelvis and calyces filled with contrast: tubes and cups, inside KidneyOrgan.
double KidneyCalyces(const Vec3& p);

/// Depth coordinate y of the convex border where the plane x = sheet_x meets it.
double KidneyEntryY_mm(double sheet_x_mm);

template <typename Function>
Vec3 NumericGradient(const Function& f, const Vec3& p, double h = 0.05) {
  const Vec3 x(h, 0, 0), y(0, h, 0), z(0, 0, h);
  return Vec3(f(p + x) - f(p - x), f(p + y) - f(p - y), f(p + z) - f(p - z)) / (2.0 * h);
}

}  // namespace kerf
