#include "Adapters/Itk/Outline.h"

#include <itkDiscreteGaussianImageFilter.h>

#include <cmath>
#include <optional>

#include "Adapters/Itk/ImageBridge.h"
#include "Adapters/Itk/Statistics.h"

namespace kerf {
namespace {

using itk_bridge::Image3;

constexpr std::size_t kEnough = 50;  // voxels for a median
constexpr double kSmooth = 0.8;      // of a voxel, standard deviation

ScalarField Gaussian(const ScalarField& field, const Vec3& sigma_mm) {
  using Image = Image3<float>;
  auto filter = itk::DiscreteGaussianImageFilter<Image, Image>::New();
  filter->SetInput(itk_bridge::ToItk<float>(field.grid, field.values));
  const Vec3 variance = sigma_mm.cwiseAbs2();
  filter->SetVariance(variance.data());
  filter->SetMaximumError(0.002);
  filter->Update();
  ScalarField out;
  out.grid = field.grid;
  out.values = itk_bridge::VoxelsOf<float>(filter->GetOutput());
  return out;
}

/// 2·G − G∗G: its second moment is zero, so that what is curved keeps its size.
ScalarField SmoothKeepingSize(const ScalarField& field, const Vec3& sigma_mm) {
  ScalarField once = Gaussian(field, sigma_mm);
  const ScalarField twice = Gaussian(once, sigma_mm);
  for (std::size_t i = 0; i < once.values.size(); ++i)
    once.values[i] = 2 * once.values[i] - twice.values[i];
  return once;
}

/// What a body and the parenchyma around it look like.
struct Contrast {
  double own_hu = 0, around_hu = 0, noise_hu = 0;
  double Difference() const { return own_hu - around_hu; }
};

/// @param depth, inside signed distances of the body and of the organ, mm
std::optional<Contrast> Measure(const ScalarField& hu, const ScalarField& depth,
                                const ScalarField& inside, const Mask* other) {
  std::vector<float> depths, own, around;
  for (const float d : depth.values)
    if (d > 0) depths.push_back(d);
  if (depths.empty()) return {};
  // Partial volumes at the rim do not count; of thin bodies it is the larger part.
  const double middle = std::max(Quantile(depths, 0.65), 0.8 * hu.grid.spacing_mm.minCoeff());
  for (std::size_t i = 0; i < hu.values.size(); ++i) {
    const float d = depth.values[i];
    if (d >= middle) own.push_back(hu.values[i]);
    if (d < -2.5 && d > -6.5 && inside.values[i] > 2.5 && !(other && other->values[i]))
      around.push_back(hu.values[i]);
  }
  if (own.empty() || around.size() < kEnough) return {};
  Contrast contrast;
  contrast.own_hu = Median(own);
  contrast.around_hu = Median(around);
  contrast.noise_hu = Spread(around, contrast.around_hu);
  if (std::abs(contrast.Difference()) < 1) return {};
  return contrast;
}

/// Components of `candidate` that hold a voxel of `body`.
Mask KeepTouching(const Mask& candidate, const Mask& body) {
  std::vector<std::size_t> sizes;
  const auto components = Components(candidate, &sizes);
  std::vector<char> keep(sizes.size() + 1, 0);
  for (std::size_t i = 0; i < body.values.size(); ++i)
    if (body.values[i]) keep[std::size_t(components.values[i])] = 1;
  keep[0] = 0;
  Mask out(candidate.grid, 0);
  for (std::size_t i = 0; i < out.values.size(); ++i)
    out.values[i] = std::uint8_t(keep[std::size_t(components.values[i])]);
  return out;
}

/// Values where `valid`, elsewhere the mean of the valid ones close by; 0 where there are none.
ScalarField Extended(const ScalarField& field, const Mask& valid, double reach_mm) {
  ScalarField sum(field.grid, 0.f), weight(field.grid, 0.f);
  for (std::size_t i = 0; i < field.values.size(); ++i)
    if (valid.values[i]) {
      sum.values[i] = field.values[i];
      weight.values[i] = 1;
    }
  sum = Gaussian(sum, Vec3::Constant(reach_mm));
  weight = Gaussian(weight, Vec3::Constant(reach_mm));
  ScalarField out = field;
  for (std::size_t i = 0; i < out.values.size(); ++i)
    if (!valid.values[i])
      out.values[i] = weight.values[i] > 1e-3f ? sum.values[i] / weight.values[i] : 0.f;
  return out;
}

/// Thin ends hold less than half of a voxel: what goes on from the body at a quarter of the
/// contrast, clear of its own blurred rim.
void FollowThinEnds(const ScalarField& fraction, double noise, const ScalarField& inside,
                    Mask* body) {
  constexpr double kLeast = 0.25, kNoises = 2.5, kReach_mm = 12, kRim_mm = 1.5;
  constexpr std::size_t kLeastVoxels = 4;
  const double voxel_mm = fraction.grid.spacing_mm.maxCoeff();
  Mask faint(body->grid, 0);
  for (std::size_t i = 0; i < faint.values.size(); ++i)
    faint.values[i] =
        inside.values[i] > kRim_mm && fraction.values[i] > std::max(kLeast, kNoises * noise);
  const Mask reached = GeodesicGrow(*body, faint, kReach_mm);
  const ScalarField depth = SignedDistance_mm(*body);
  Mask ends(body->grid, 0);
  for (std::size_t i = 0; i < ends.values.size(); ++i)
    ends.values[i] = reached.values[i] && depth.values[i] < -1.1 * voxel_mm;
  std::vector<std::size_t> sizes;
  const auto components = Components(ends, &sizes);
  for (std::size_t i = 0; i < ends.values.size(); ++i)
    ends.values[i] =
        components.values[i] > 0 && sizes[std::size_t(components.values[i] - 1)] >= kLeastVoxels;
  if (Count(ends) == 0) return;
  const ScalarField to_ends = SignedDistance_mm(ends);
  for (std::size_t i = 0; i < ends.values.size(); ++i)
    if (reached.values[i] && to_ends.values[i] > -1.2 * voxel_mm) body->values[i] = 1;
}

}  // namespace

Mask OutlineCompact(const ScalarField& hu, const Mask& body, const Mask& organ, const Mask& other) {
  constexpr double kReach_mm = 2.5, kSmooth_mm = 1;
  if (Count(body) == 0) return body;
  const ScalarField depth = SignedDistance_mm(body), inside = SignedDistance_mm(organ),
                    to_other = SignedDistance_mm(other);
  const auto contrast = Measure(hu, depth, inside, &other);
  if (!contrast) return body;
  const double partial_mm = 0.8 * hu.grid.spacing_mm.maxCoeff();
  ScalarField fraction(hu.grid, 0.f);
  Mask valid(hu.grid, 0);
  for (std::size_t i = 0; i < hu.values.size(); ++i) {
    const double f = (hu.values[i] - contrast->around_hu) / contrast->Difference();
    fraction.values[i] = float(std::clamp(f, -0.5, 1.5));
    valid.values[i] = inside.values[i] > partial_mm && to_other.values[i] < -partial_mm;
  }
  fraction = SmoothKeepingSize(Extended(fraction, valid, kSmooth_mm),
                               (kSmooth * hu.grid.spacing_mm).cwiseMax(kSmooth_mm));
  Mask outlined(hu.grid, 0);
  for (std::size_t i = 0; i < outlined.values.size(); ++i)
    outlined.values[i] = fraction.values[i] > 0.5f && organ.values[i] && !other.values[i] &&
                         depth.values[i] > -kReach_mm;
  return KeepTouching(outlined, body);
}

Mask OutlineBranching(const ScalarField& hu, const Mask& body, const Mask& organ) {
  constexpr double kLeastNoise = 0.1;             // of the contrast
  constexpr double kRim_mm = 1.5, kFar_mm = 3.5;  // beyond the body: partial volumes, candidates
  if (Count(body) == 0) return body;
  const ScalarField depth = SignedDistance_mm(body), inside = SignedDistance_mm(organ);
  const auto contrast = Measure(hu, depth, inside, nullptr);
  if (!contrast || contrast->noise_hu < kLeastNoise * contrast->Difference()) return body;
  ScalarField fraction(hu.grid, 0.f);
  double volume = 0;
  for (std::size_t i = 0; i < hu.values.size(); ++i) {
    if (!organ.values[i]) continue;
    const double f = (hu.values[i] - contrast->around_hu) / contrast->Difference();
    fraction.values[i] = float(std::clamp(f, -1.5, 2.5));
    if (depth.values[i] > -kRim_mm) volume += fraction.values[i];
  }
  fraction = SmoothKeepingSize(fraction, kSmooth * hu.grid.spacing_mm);
  std::vector<float> near, far;
  for (std::size_t i = 0; i < hu.values.size(); ++i) {
    if (!organ.values[i]) continue;
    if (depth.values[i] > -kFar_mm)
      near.push_back(fraction.values[i]);
    else if (depth.values[i] > -2 * kFar_mm && inside.values[i] > 2 * kRim_mm)
      far.push_back(fraction.values[i]);
  }
  if (near.empty() || far.empty()) return body;
  const double share = std::clamp(volume / double(near.size()), 0., 1.);
  const double level = std::clamp(Quantile(near, 1 - share), 0.35, 0.6);
  Mask outlined(hu.grid, 0);
  for (std::size_t i = 0; i < outlined.values.size(); ++i)
    outlined.values[i] =
        organ.values[i] && depth.values[i] > -kFar_mm && fraction.values[i] > level;
  outlined = KeepTouching(outlined, body);
  FollowThinEnds(fraction, Spread(far, Median(far)), inside, &outlined);
  return outlined;
}

}  // namespace kerf
