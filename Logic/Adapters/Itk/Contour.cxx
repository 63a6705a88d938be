#include "Adapters/Itk/Contour.h"

#include <itkGeodesicActiveContourLevelSetImageFilter.h>
#include <itkGradientMagnitudeRecursiveGaussianImageFilter.h>

#include <cmath>

#include "Adapters/Itk/ImageBridge.h"

namespace kerf {

using itk_bridge::Image3;

ScalarField EdgeStrength(const ScalarField& image, Progress& progress) {
  using Image = Image3<float>;
  auto gradient = itk::GradientMagnitudeRecursiveGaussianImageFilter<Image, Image>::New();
  gradient->SetInput(itk_bridge::ToItk<float>(image.grid, image.values));
  gradient->SetSigma(image.grid.spacing_mm.maxCoeff());
  itk_bridge::Run(gradient.GetPointer(), progress, "edges");
  ScalarField out;
  out.grid = image.grid;
  out.values = itk_bridge::VoxelsOf<float>(gradient->GetOutput());
  return out;
}

ScalarField SnapToEdges(const ScalarField& edges, const ScalarField& inside, int iterations,
                        Progress& progress) {
  using Image = Image3<float>;
  std::vector<float> edge = edges.values;
  // Edge strength relative to what is seen along the boundary itself: no threshold in HU.
  std::vector<float> near;
  for (std::size_t i = 0; i < edge.size(); ++i)
    if (std::abs(inside.values[i]) < 1.5 * edges.grid.spacing_mm.maxCoeff())
      near.push_back(edge[i]);
  if (near.empty()) return inside;
  std::nth_element(near.begin(), near.begin() + near.size() / 2, near.end());
  const float middle = std::max(near[near.size() / 2], 1e-3f);
  for (float& g : edge) g = 1 / (1 + (g / middle) * (g / middle));

  auto contour = itk::GeodesicActiveContourLevelSetImageFilter<Image, Image>::New();
  ScalarField start = inside;  // ITK: negative inside
  for (float& v : start.values) v = -v;
  contour->SetInput(itk_bridge::ToItk<float>(start.grid, start.values));
  contour->SetFeatureImage(itk_bridge::ToItk<float>(edges.grid, edge));
  contour->SetPropagationScaling(0);
  contour->SetCurvatureScaling(0.3);
  contour->SetAdvectionScaling(1.0);
  contour->SetMaximumRMSError(0);
  contour->SetNumberOfIterations(static_cast<unsigned>(iterations));
  itk_bridge::Run(contour.GetPointer(), progress, "active contour");
  ScalarField out;
  out.grid = edges.grid;
  out.values = itk_bridge::VoxelsOf<float>(contour->GetOutput());
  for (float& v : out.values) v = -v;
  return out;
}

Mask AtHalfContrast(const ScalarField& image, const Mask& organ) {
  constexpr double kProbe_mm = 3;  // past the partial volumes
  constexpr float kLeastContrast_hu = 60;
  const ScalarField depth = SignedDistance_mm(organ);
  const auto& grid = image.grid;
  const auto& s = grid.size;
  const double band = grid.spacing_mm.maxCoeff();
  const auto value = [&](const Vec3& index) {
    Eigen::Vector3i at;
    for (int a = 0; a < 3; ++a) at[a] = std::clamp(int(std::lround(index[a])), 0, s[a] - 1);
    return image.values[grid.Offset(at[0], at[1], at[2])];
  };
  Mask settled = organ;
  for (int k = 1; k + 1 < s[2]; ++k)
    for (int j = 1; j + 1 < s[1]; ++j)
      for (int i = 1; i + 1 < s[0]; ++i) {
        const std::size_t at = grid.Offset(i, j, k);
        if (std::abs(depth.values[at]) > band) continue;
        const Vec3 inwards(
            (depth.values[grid.Offset(i + 1, j, k)] - depth.values[grid.Offset(i - 1, j, k)]) /
                grid.spacing_mm[0],
            (depth.values[grid.Offset(i, j + 1, k)] - depth.values[grid.Offset(i, j - 1, k)]) /
                grid.spacing_mm[1],
            (depth.values[grid.Offset(i, j, k + 1)] - depth.values[grid.Offset(i, j, k - 1)]) /
                grid.spacing_mm[2]);
        if (inwards.norm() < 1e-6) continue;
        const Vec3 step = kProbe_mm * inwards.normalized().cwiseQuotient(grid.spacing_mm);
        const float inner = value(Vec3(i, j, k) + step), outer = value(Vec3(i, j, k) - step);
        if (inner - outer < kLeastContrast_hu) continue;
        if (image.values[at] > 0.5f * (inner + outer)) settled.values[at] = 1;
      }
  return settled;
}

}  // namespace kerf
