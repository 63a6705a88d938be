#include <gtest/gtest.h>
#include <itkCurvatureAnisotropicDiffusionImageFilter.h>
#include <itkSignedMaurerDistanceMapImageFilter.h>

#include <cmath>

#include "Adapters/Itk/Field.h"
#include "Adapters/Itk/ImageBridge.h"

namespace kerf {
namespace {

GridGeometry Grid() {
  GridGeometry grid;
  grid.size = {21, 17, 13};
  grid.spacing_mm = {0.8, 1.0, 1.5};
  return grid;
}

/// Uneven, and the same on every platform.
float Noise(std::size_t at) { return static_cast<float>((at * 2654435761u >> 20) % 64) - 32; }

TEST(SignedDistance, IsTheDistanceToTheNearestVoxelOfTheBorder) {
  Mask mask(Grid(), 0);
  for (std::size_t v = 0; v < mask.values.size(); ++v) mask.values[v] = v * 7919 % 31 == 0;
  for (int k = 4; k < 9; ++k)
    for (int j = 5; j < 12; ++j)
      for (int i = 6; i < 15; ++i) mask.values[mask.grid.Offset(i, j, k)] = 1;
  const ScalarField distance = SignedDistance_mm(mask);
  const auto at = [&](int i, int j, int k) { return mask.grid.Offset(i, j, k); };
  const auto& n = mask.grid.size;
  std::vector<Vec3> border;
  const auto each = [&n](auto f) {
    for (int k = 0; k < n[2]; ++k)
      for (int j = 0; j < n[1]; ++j)
        for (int i = 0; i < n[0]; ++i) f(i, j, k);
  };
  each([&](int i, int j, int k) {
    bool rim = false;
    for (int c = std::max(0, k - 1); c <= std::min(n[2] - 1, k + 1); ++c)
      for (int b = std::max(0, j - 1); b <= std::min(n[1] - 1, j + 1); ++b)
        for (int a = std::max(0, i - 1); a <= std::min(n[0] - 1, i + 1); ++a)
          rim = rim || !mask.values[at(a, b, c)];
    if (rim && mask.values[at(i, j, k)])
      border.push_back(Vec3(i, j, k).cwiseProduct(mask.grid.spacing_mm));
  });
  const double half = 0.5 * std::cbrt(mask.grid.spacing_mm.prod());
  each([&](int i, int j, int k) {
    double nearest = 1e9;
    for (const Vec3& b : border)
      nearest = std::min(nearest, (b - Vec3(i, j, k).cwiseProduct(mask.grid.spacing_mm)).norm());
    const double expected = (mask.values[at(i, j, k)] ? nearest : -nearest) + half;
    EXPECT_NEAR(distance.values[at(i, j, k)], expected, 1e-4) << i << ' ' << j << ' ' << k;
  });
}

TEST(SignedDistance, OfNothingAndOfAllIsFar) {
  EXPECT_EQ(SignedDistance_mm(Mask(Grid(), 0)).values[5], -1e6f);
  EXPECT_EQ(SignedDistance_mm(Mask(Grid(), 1)).values[5], 1e6f);
}

TEST(Denoise, SmoothsTissueAndKeepsEdges) {
  ScalarField image(Grid(), 0.f);
  const int half = image.grid.size[0] / 2;
  for (std::size_t v = 0; v < image.values.size(); ++v)
    image.values[v] = Noise(v) + (int(v % image.grid.size[0]) > half ? 400.f : 0.f);
  Progress silent;
  const ScalarField smooth = Denoise(image, 15, silent);
  double before = 0, after = 0;
  for (std::size_t v = 0; v < image.values.size(); ++v) {
    const int i = int(v % image.grid.size[0]);
    const float level = i > half ? 400.f : 0.f;
    before += std::pow(image.values[v] - level, 2);
    after += std::pow(smooth.values[v] - level, 2);
    if (i <= half)
      EXPECT_LT(smooth.values[v], 200) << v;
    else
      EXPECT_GT(smooth.values[v], 200) << v;
  }
  EXPECT_LT(after, 0.5 * before);
}

TEST(Denoise, IsBlindToMirrorsAndLeavesWhatIsEven) {
  ScalarField image(Grid(), 0.f), mirrored = image;
  const auto& n = image.grid.size;
  for (std::size_t v = 0; v < image.values.size(); ++v) image.values[v] = Noise(v);
  const auto mirror = [&](std::size_t v) {
    const int i = int(v % n[0]), j = int(v / n[0] % n[1]), k = int(v / n[0] / n[1]);
    return image.grid.Offset(n[0] - 1 - i, n[1] - 1 - j, n[2] - 1 - k);
  };
  for (std::size_t v = 0; v < image.values.size(); ++v)
    mirrored.values[mirror(v)] = image.values[v];
  Progress silent;
  const ScalarField one = Denoise(image, 5, silent), other = Denoise(mirrored, 5, silent);
  for (std::size_t v = 0; v < image.values.size(); ++v)
    EXPECT_NEAR(one.values[v], other.values[mirror(v)], 1e-3) << v;
  const ScalarField flat(Grid(), 42.f);
  EXPECT_EQ(Denoise(flat, 3, silent).values, flat.values);
}

/// Both are there because they are faster than ITK's filters (docs/reference/segmentation.md). To
/// the bit in a release build; others contract products and sums differently.
#ifdef NDEBUG
constexpr float kDifference = 0;
#else
constexpr float kDifference = 1e-3f;
#endif
void ExpectSame(const std::vector<float>& ours, const std::vector<float>& theirs) {
  ASSERT_EQ(ours.size(), theirs.size());
  for (std::size_t v = 0; v < ours.size(); ++v) ASSERT_NEAR(ours[v], theirs[v], kDifference) << v;
}

TEST(SignedDistance, IsThatOfItk) {
  Mask mask(Grid(), 0);
  for (std::size_t v = 0; v < mask.values.size(); ++v) mask.values[v] = Noise(v) > 28;
  for (int k = 3; k < 10; ++k)
    for (int j = 4; j < 14; ++j)
      for (int i = 5; i < 17; ++i) mask.values[mask.grid.Offset(i, j, k)] = 1;
  using itk_bridge::Image3;
  auto filter = itk::SignedMaurerDistanceMapImageFilter<Image3<std::uint8_t>, Image3<float>>::New();
  filter->SetInput(itk_bridge::ToItk<std::uint8_t>(mask.grid, mask.values));
  filter->SetUseImageSpacing(true);
  filter->SetSquaredDistance(false);
  filter->SetInsideIsPositive(true);
  filter->Update();
  std::vector<float> theirs = itk_bridge::VoxelsOf<float>(filter->GetOutput());
  const float half = float(0.5 * std::cbrt(mask.grid.spacing_mm.prod()));
  for (float& d : theirs) d += half;
  ExpectSame(SignedDistance_mm(mask).values, theirs);
}

TEST(Denoise, IsThatOfItk) {
  ScalarField image(Grid(), 0.f);
  for (std::size_t v = 0; v < image.values.size(); ++v)
    image.values[v] = Noise(v) + (v % 21 > 10 ? 150.f : 0.f);
  using Image = itk_bridge::Image3<float>;
  auto filter = itk::CurvatureAnisotropicDiffusionImageFilter<Image, Image>::New();
  filter->SetInput(itk_bridge::ToItk<float>(image.grid, image.values));
  filter->SetNumberOfIterations(5);
  filter->UseImageSpacingOff();
  filter->SetTimeStep(0.0625);
  filter->SetConductanceParameter(2.0);
  filter->Update();
  Progress silent;
  ExpectSame(Denoise(image, 5, silent).values, itk_bridge::VoxelsOf<float>(filter->GetOutput()));
}

}  // namespace
}  // namespace kerf
