#include "Phantom/PhantomMotion.h"

#include <algorithm>
#include <cmath>
#include <complex>

namespace kerf {
namespace {

constexpr double kProcessZone_mm = 3.0;
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

std::array<double, PhantomMotion::kFields> PhantomMotion::FieldDepths_mm(double frame) const {
  const double a = TipDepth_mm(frame), zone = std::min(kProcessZone_mm, 0.5 * a);
  return {a - zone, a - 0.4 * zone, a};
}

double PhantomMotion::Opening_mm(double depth_mm, double frame) const {
  double sum = 0.0;
  for (double a : FieldDepths_mm(frame))
    if (depth_mm < a) sum += std::sqrt(a * a - depth_mm * depth_mm);
  return 2.0 * Strain(frame) * sum / kFields;
}

Vec3 PhantomMotion::Position(const Vec3& rest, int side, double frame) const {
  const double strain = Strain(frame);
  if (strain == 0.0) return rest;  // bit-exact at rest
  const double s = SheetDistance_mm(rest), d = Depth_mm(rest);
  // Points of the sheet carry rounding errors: there `side` decides.
  const double sign = s > 1e-6 ? 1.0 : s < -1e-6 ? -1.0 : side;
  const double reach = m_.grip_reach_mm;
  const double fade = reach > 0.0 ? std::tanh(s / reach) : 0.0;
  const double h = reach > 0.0 ? reach * fade : s;
  const double fade_slope = 1.0 - fade * fade;

  const std::complex<double> z(std::abs(h), std::abs(d));
  double lift = 0.0, share_y = 0.0, share_z = 0.0;
  for (double depth : FieldDepths_mm(frame)) {
    const std::complex<double> w = std::sqrt(z * z + depth * depth);
    lift += w.real() / kFields;
    // ∂ Re w/∂h, blunted at the tip: more for y, whose slope along y must stay below one.
    const double slope = depth > 0.0 ? (z * std::conj(w)).real() : 1.0;
    const double square = depth > 0.0 ? std::norm(w) : 1.0;
    share_y += slope / (square + 0.25 * depth * depth) / kFields;
    share_z += slope / (square + 0.10 * depth * depth) / kFields;
  }
  Vec3 p = rest;
  p.x() += strain * sign * lift;
  // Contraction across the pull: none on the unloaded lips; z takes up what y leaves.
  const double contraction = 1.0 / std::sqrt(1.0 + strain * fade_slope * share_y);
  p.y() = m_.contraction_y_mm + (rest.y() - m_.contraction_y_mm) * contraction;
  p.z() = rest.z() / ((1.0 + strain * fade_slope * share_z) * contraction);

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
