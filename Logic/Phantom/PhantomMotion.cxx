#include "Phantom/PhantomMotion.h"

#include <algorithm>
#include <cmath>
#include <complex>

namespace kerf {
namespace {

constexpr double kDegree = 3.14159265358979323846 / 180.0;

/// 0 before `begin`, 1 after `end`, two continuous derivatives.
double SmoothStep(double t, double begin, double end) {
  const double x = std::clamp((t - begin) / (end - begin), 0.0, 1.0);
  return x * x * x * (x * (6.0 * x - 15.0) + 10.0);
}

}  // namespace

double PhantomMotion::SheetX_mm(double y_mm) const {
  const double depth = y_mm - m_.entry_y_mm;
  return m_.sheet_x_mm + m_.sheet_bend_per_mm * depth * depth;
}

double PhantomMotion::SheetDistance_mm(const Vec3& rest) const {
  return rest.x() - SheetX_mm(rest.y());
}

double PhantomMotion::TipDepth_mm(double frame) const {
  if (!m_.has_cut) return 0.0;
  // A surgeon's hand: quick in the middle, but moving from the first frame on.
  const double x = std::clamp((frame - m_.start_frame) / (m_.end_frame - m_.start_frame), 0.0, 1.0);
  const double eased = 0.5 * x + 0.5 * x * x * (3.0 - 2.0 * x);
  return m_.final_depth_mm * eased;
}

double PhantomMotion::Strain(double frame) const {
  return m_.preload_strain * SmoothStep(frame, m_.load_start_frame, m_.preload_end_frame) +
         (m_.final_strain - m_.preload_strain) *
             SmoothStep(frame, m_.preload_end_frame, m_.load_end_frame);
}

double PhantomMotion::Opening_mm(double depth_mm, double frame) const {
  const double a = TipDepth_mm(frame);
  return depth_mm < a ? 2.0 * Strain(frame) * std::sqrt(a * a - depth_mm * depth_mm) : 0.0;
}

Vec3 PhantomMotion::Position(const Vec3& rest, int side, double frame) const {
  const double strain = Strain(frame);
  if (strain == 0.0) return rest;  // bit-exact at rest
  const double s = SheetDistance_mm(rest), d = Depth_mm(rest), a = TipDepth_mm(frame);
  // Sheet points carry rounding errors: within a nanometre `side` decides.
  const double sign = s > 1e-6 ? 1.0 : s < -1e-6 ? -1.0 : side;
  const double reach = m_.grip_reach_mm;
  const double fade = reach > 0.0 ? std::tanh(s / reach) : 0.0;
  const double h = reach > 0.0 ? reach * fade : s;
  const double slope = 1.0 - fade * fade;

  const std::complex<double> z(std::abs(h), std::abs(d));
  const std::complex<double> w = std::sqrt(z * z + a * a);
  Vec3 p = rest;
  p.x() += strain * sign * w.real();

  // Contraction across the pull: none on the unloaded lips. The tip's singularity is blunted, more
  // for y (whose slope along y must stay below one) than for z, which takes up the rest.
  auto stretch = [&](double blunt) {
    return 1.0 + strain * slope *
                     (a > 0.0 ? (z * std::conj(w)).real() / (std::norm(w) + blunt * a * a) : 1.0);
  };
  const double contraction = 1.0 / std::sqrt(stretch(0.25));
  p.y() = m_.contraction_y_mm + (rest.y() - m_.contraction_y_mm) * contraction;
  p.z() = rest.z() / (stretch(0.09) * contraction);

  const double load = strain / m_.final_strain;
  const double t = s / 50.0;
  if (m_.twist_deg != 0.0) {
    const double angle = load * m_.twist_deg * kDegree * t;
    const double c = std::cos(angle), n = std::sin(angle);
    const double y = p.y() - m_.contraction_y_mm;
    p = Vec3(p.x(), m_.contraction_y_mm + c * y - n * p.z(), n * y + c * p.z());
  }
  if (m_.bend_mm != 0.0) {
    // Sections turn with the bent axis.
    p.x() -= load * m_.bend_mm * 2.0 * t / 50.0 * (rest.y() - m_.contraction_y_mm);
    p.y() += load * m_.bend_mm * t * t;
  }
  p.z() += load * m_.bow_mm * std::exp(-t * t);
  return p;
}

}  // namespace kerf
