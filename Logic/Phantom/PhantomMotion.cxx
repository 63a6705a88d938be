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

double PhantomMotion::Depth_mm(const Vec3& rest, int cut) const {
  return m_.cuts[cut].into * (rest.y() - m_.cuts[cut].entry_y_mm);
}

double PhantomMotion::SheetX_mm(double y_mm, int cut) const {
  const double depth = Depth_mm({0.0, y_mm, 0.0}, cut);
  return m_.cuts[cut].sheet_x_mm + m_.cuts[cut].sheet_bend_per_mm * depth * depth;
}

double PhantomMotion::SheetDistance_mm(const Vec3& rest, int cut) const {
  return rest.x() - SheetX_mm(rest.y(), cut);
}

double PhantomMotion::MiddleX_mm(double y_mm) const {
  if (m_.cuts.empty()) return m_.middle_x_mm;
  const double depth = Depth_mm({0.0, y_mm, 0.0}, 0);
  return m_.middle_x_mm + m_.cuts[0].sheet_bend_per_mm * depth * depth;
}

double PhantomMotion::Share(int cut) const {
  return Fade(m_.cuts[cut].sheet_x_mm - m_.middle_x_mm).slope;
}

int PhantomMotion::Region(const Vec3& rest) const {
  int region = 0;
  while (region < CutCount() && SheetDistance_mm(rest, region) >= 0.0) ++region;
  return region;
}

PhantomMotion::Faded PhantomMotion::Fade(double distance_mm) const {
  const double reach = m_.grip_reach_mm;
  if (reach <= 0.0) return {distance_mm, 1.0};
  const double fade = std::tanh(distance_mm / reach);
  return {reach * fade, 1.0 - fade * fade};
}

double PhantomMotion::TipDepth_mm(double frame, int cut) const {
  const PhantomCutParameters& c = m_.cuts[cut];
  // A surgeon's hand: quick in the middle, but moving from the first frame on.
  const double x = std::clamp((frame - c.start_frame) / (c.end_frame - c.start_frame), 0.0, 1.0);
  const double eased = 0.5 * x + 0.5 * x * x * (3.0 - 2.0 * x);
  return c.final_depth_mm * eased;
}

double PhantomMotion::Strain(double frame) const {
  return m_.preload_strain * SmoothStep(frame, m_.load_start_frame, m_.preload_end_frame) +
         (m_.final_strain - m_.preload_strain) *
             SmoothStep(frame, m_.preload_end_frame, m_.load_end_frame);
}

std::array<double, PhantomMotion::kFields> PhantomMotion::FieldDepths_mm(double frame,
                                                                         int cut) const {
  const double a = TipDepth_mm(frame, cut), zone = std::min(kProcessZone_mm, 0.5 * a);
  return {a - zone, a - 0.4 * zone, a};
}

double PhantomMotion::Opening_mm(double depth_mm, double frame, int cut) const {
  double sum = 0.0;
  for (double a : FieldDepths_mm(frame, cut))
    if (depth_mm < a) sum += std::sqrt(a * a - depth_mm * depth_mm);
  return 2.0 * Strain(frame) * Share(cut) * sum / kFields;
}

Vec3 PhantomMotion::Position(const Vec3& rest, int region, double frame) const {
  const double strain = Strain(frame);
  if (strain == 0.0) return rest;  // bit-exact at rest
  const double s = rest.x() - MiddleX_mm(rest.y());
  const Faded whole = Fade(s);
  // The plain stretch less what the cuts take of it, and what they put in its place.
  double plain = whole.h, plain_slope = whole.slope, opened = 0.0, slope_y = 0.0, slope_z = 0.0;
  for (int cut = 0; cut < CutCount(); ++cut) {
    const double from_sheet = SheetDistance_mm(rest, cut), d = Depth_mm(rest, cut);
    // Points of the sheet carry rounding errors: there `region` decides.
    const double sign = from_sheet > 1e-6 ? 1.0 : from_sheet < -1e-6 ? -1.0 : region > cut ? 1 : -1;
    const Faded at = Fade(from_sheet);
    const double share = Share(cut);
    plain -= share * at.h;
    plain_slope -= share * at.slope;
    const std::complex<double> z(std::abs(at.h), std::abs(d));
    double lift = 0.0, share_y = 0.0, share_z = 0.0;
    for (double depth : FieldDepths_mm(frame, cut)) {
      const std::complex<double> w = std::sqrt(z * z + depth * depth);
      lift += w.real() / kFields;
      // ∂ Re w/∂h, blunted at the tip: more for y, whose slope along y must stay below one.
      const double slope = depth > 0.0 ? (z * std::conj(w)).real() : 1.0;
      const double square = depth > 0.0 ? std::norm(w) : 1.0;
      share_y += slope / (square + 0.25 * depth * depth) / kFields;
      share_z += slope / (square + 0.10 * depth * depth) / kFields;
    }
    opened += share * sign * lift;
    slope_y += share * at.slope * share_y;
    slope_z += share * at.slope * share_z;
  }
  Vec3 p = rest;
  p.x() += strain * (plain + opened);
  // Contraction across the pull: none on the unloaded lips; z takes up what y leaves.
  const double contraction = 1.0 / std::sqrt(1.0 + strain * (plain_slope + slope_y));
  p.y() = m_.contraction_y_mm + (rest.y() - m_.contraction_y_mm) * contraction;
  p.z() = rest.z() / ((1.0 + strain * (plain_slope + slope_z)) * contraction);

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
