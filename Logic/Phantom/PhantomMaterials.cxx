#include "Phantom/PhantomMaterials.h"

#include <algorithm>
#include <cmath>

#include "Phantom/Noise.h"
#include "Phantom/PhantomShape.h"

namespace kerf {
namespace {

Vec3 Mix(const Vec3& a, const Vec3& b, double t) { return a + t * (b - a); }

/// 1 on the centre line of a vessel of a branching pattern, 0 beside it: where a warped noise
/// crosses zero.
double Vessels(const Vec3& p, double spacing_mm, double width, std::uint32_t seed) {
  const Vec3 q = p / spacing_mm;
  const Vec3 warp(ValueNoise(q * 1.7, seed + 1), ValueNoise(q * 1.7, seed + 2),
                  ValueNoise(q * 1.7, seed + 3));
  const double n = ValueNoise(q + 0.35 * warp, seed);
  // Thick in places, gone in others.
  const double calibre = width * (0.35 + 0.65 * SmoothRamp(warp.x(), -0.4, 0.6));
  return 1.0 - SmoothRamp(std::abs(n), 0.35 * calibre, calibre);
}

/// Turns the lattice of the noise away from the organ's axes, along which its cells would show.
Vec3 Turned(const Vec3& p) {
  static const Mat3 turn = (Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()) *
                            Eigen::AngleAxisd(1.1, Vec3(3, -1, 1).normalized()))
                               .toRotationMatrix();
  return turn * p;
}

/// Slope of an uneven surface: the gradient of two octaves of noise, times `height`.
Vec3 Bump(const Vec3& p, double size_mm, double height, std::uint32_t seed) {
  const double h = 0.1 * size_mm;
  auto relief = [&](const Vec3& q) {
    return ValueNoise(Turned(q) / size_mm, seed) +
           0.5 * ValueNoise(Turned(Turned(q)) / (0.47 * size_mm), seed + 9);
  };
  const double centre = relief(p);
  return -height / h *
         Vec3(relief(p + Vec3(h, 0, 0)) - centre, relief(p + Vec3(0, h, 0)) - centre,
              relief(p + Vec3(0, 0, h)) - centre);
}

}  // namespace

SurfaceLook KidneyCapsule(const Vec3& p, std::uint32_t seed) {
  SurfaceLook look;
  const Vec3 q = Turned(p);
  const double mottle = FractalNoise(q / 9.0, 3, seed);
  const double grain = FractalNoise(q / 2.1, 2, seed + 11), fine = ValueNoise(q / 0.75, seed + 13);
  Vec3 colour =
      Mix(Vec3(0.22, 0.030, 0.022), Vec3(0.37, 0.085, 0.058), SmoothRamp(mottle, -0.45, 0.45));
  colour *= 1.0 + 0.75 * grain + 0.30 * fine;
  // Pale dots: the tips of the cortex's lobules.
  const double dots = SmoothRamp(ValueNoise(q / 1.25, seed + 17), 0.52, 0.75);
  colour = Mix(colour, Vec3(0.52, 0.21, 0.14), 0.55 * dots);
  // Stellate veins under the capsule, coarse and fine.
  colour = Mix(colour, Vec3(0.075, 0.008, 0.012), 0.85 * Vessels(q, 12.0, 0.085, seed + 20));
  colour = Mix(colour, Vec3(0.13, 0.012, 0.014), 0.75 * Vessels(q, 5.2, 0.10, seed + 30));
  // Tags of perirenal fat that stayed on the capsule: ragged, uneven.
  const double tags = FractalNoise(q / 9.0 + Vec3(7, 3, 1), 4, seed + 40) + 0.05 * fine;
  const double fat = SmoothRamp(tags, 0.27, 0.36);
  colour = Mix(colour, Vec3(0.47, 0.27, 0.085) * (1.0 + 0.6 * grain + 0.25 * fine), 0.75 * fat);
  const double tumour = 1.0 - SmoothRamp(KidneyTumour(p), 0.2, 1.8);
  if (tumour > 0.0) {
    Vec3 lesion = Vec3(0.45, 0.21, 0.11) * (1.0 + 0.7 * grain + 0.25 * fine);
    lesion = Mix(lesion, Vec3(0.26, 0.02, 0.03), 0.8 * Vessels(q, 3.4, 0.15, seed + 50));
    colour = Mix(colour, lesion, 0.8 * tumour);
  }
  look.albedo = colour;
  look.gloss = 0.75 - 0.4 * fat;
  look.bump = Bump(p, 2.2, 0.10, seed + 60) + Bump(p, 8.0, 0.25, seed + 61);
  return look;
}

SurfaceLook KidneySection(const Vec3& p, std::uint32_t seed) {
  SurfaceLook look;
  const double depth = -KidneyOrgan(p);
  const double grain = FractalNoise(p / 1.1, 2, seed + 70);
  // Cortex outside, striated pyramids towards the sinus.
  const Vec3 from_sinus = p - Vec3(p.x(), 9.0, 0.0);
  const double angle = std::atan2(from_sinus.z(), from_sinus.y());
  const double striae = ValueNoise(Vec3(angle * 14.0, 0.12 * from_sinus.norm(), 2.0), seed + 71);
  Vec3 cortex = Vec3(0.46, 0.095, 0.065) * (1.0 + 0.40 * grain);
  Vec3 medulla = Vec3(0.34, 0.040, 0.045) * (1.0 + 0.35 * striae + 0.2 * grain);
  const double pyramid = SmoothRamp(std::cos(5.0 * angle), -0.5, 0.3);
  Vec3 colour = Mix(cortex, medulla, pyramid * SmoothRamp(depth, 5.0, 7.5));
  // Oozing blood.
  const double blood = SmoothRamp(FractalNoise(p / 4.0, 3, seed + 72), 0.08, 0.24);
  colour = Mix(colour, Vec3(0.26, 0.008, 0.010), 0.8 * blood);
  // An opened calyx: pale wall around a dark lumen.
  const double calyx = KidneyCalyces(p);
  colour = Mix(colour, Vec3(0.72, 0.50, 0.42), 1.0 - SmoothRamp(calyx, 0.5, 1.1));
  colour = Mix(colour, Vec3(0.10, 0.02, 0.02), 1.0 - SmoothRamp(calyx, -0.9, -0.2));
  // The capsule's edge.
  colour = Mix(colour, Vec3(0.62, 0.38, 0.30), 1.0 - SmoothRamp(depth, 0.35, 0.8));
  look.albedo = colour;
  look.gloss = 0.5 + 0.5 * blood;
  look.bump = Bump(p, 1.6, 0.10, seed + 73);
  return look;
}

SurfaceLook SiliconeBand(const Vec3& p, bool section, std::uint32_t seed) {
  SurfaceLook look;
  const double grain = FractalNoise(p / 0.8, 2, seed);
  Vec3 colour(0.66, 0.56, 0.38);
  if (section) {
    look.albedo = 0.8 * colour * (1.0 + 0.1 * grain);
    return look;
  }
  colour = Mix(colour, Vec3(0.17, 0.08, 0.04),
               SmoothRamp(FractalNoise(p / 2.6, 2, seed + 1), 0.17, 0.22));
  colour = Mix(colour, Vec3(0.16, 0.22, 0.38),
               SmoothRamp(FractalNoise(p / 3.1, 2, seed + 2), 0.20, 0.25));
  look.albedo = colour * (1.0 + 0.35 * grain);
  look.gloss = 0.12;
  look.bump = Bump(p, 2.0, 0.03, seed + 3);
  return look;
}

SurfaceLook FatBackground(const Vec3& p, std::uint32_t seed) {
  SurfaceLook look;
  const Vec3 q = Turned(p);
  const double lobule = std::abs(ValueNoise(q / 10.0, seed + 80)) +
                        0.5 * std::abs(ValueNoise(Turned(q) / 5.0, seed + 81));
  Vec3 colour =
      Mix(Vec3(0.15, 0.055, 0.018), Vec3(0.38, 0.215, 0.070), SmoothRamp(lobule, 0.03, 0.55));
  colour *= 1.0 + 0.35 * FractalNoise(q / 1.8, 2, seed + 82);
  const double muscle =
      SmoothRamp(FractalNoise(q / 42.0 + Vec3(1, 4, 0), 3, seed + 83), 0.05, 0.30);
  const double fibre = ValueNoise(Vec3(p.x() * 0.8 + 0.3 * p.y(), p.y() * 0.05, 0.0), seed + 84);
  colour = Mix(colour, Vec3(0.21, 0.050, 0.036) * (1.0 + 0.25 * fibre), 0.75 * muscle);
  colour = Mix(colour, Vec3(0.17, 0.018, 0.020), 0.7 * Vessels(q, 26.0, 0.035, seed + 85));
  colour = Mix(colour, Vec3(0.22, 0.036, 0.030), 0.45 * Vessels(q, 12.0, 0.045, seed + 86));
  look.albedo = colour;
  look.gloss = 0.16;
  look.bump = Bump(p, 11.0, 0.9, seed + 80) + Bump(p, 3.5, 0.10, seed + 87);
  return look;
}

SurfaceLook ClothBackground(const Vec3& p, std::uint32_t seed) {
  SurfaceLook look;
  const double weave = 0.5 * (std::sin(p.x() * 5.0) + std::sin(p.y() * 5.0));
  look.albedo = Vec3(0.018, 0.085, 0.125) *
                (1.0 + 0.12 * weave + 0.35 * FractalNoise(p / 14.0, 4, seed + 90));
  look.gloss = 0.0;
  return look;
}

}  // namespace kerf
