#include "Adapters/Itk/Contour.h"

#include <itkGeodesicActiveContourLevelSetImageFilter.h>
#include <itkGradientMagnitudeRecursiveGaussianImageFilter.h>

#include <cmath>

#include "Adapters/Itk/ImageBridge.h"

namespace kerf {

using itk_bridge::Image3;

ScalarField SnapToEdges(const ScalarField& image, const ScalarField& inside, int iterations,
                        Progress& progress) {
  using Image = Image3<float>;
  auto gradient = itk::GradientMagnitudeRecursiveGaussianImageFilter<Image, Image>::New();
  gradient->SetInput(itk_bridge::ToItk<float>(image.grid, image.values));
  gradient->SetSigma(image.grid.spacing_mm.maxCoeff());
  itk_bridge::Run(gradient.GetPointer(), progress, "edges");
  std::vector<float> edge = itk_bridge::VoxelsOf<float>(gradient->GetOutput());
  // Edge strength relative to what is seen along the boundary itself: no threshold in HU.
  std::vector<float> near;
  for (std::size_t i = 0; i < edge.size(); ++i)
    if (std::abs(inside.values[i]) < 1.5 * image.grid.spacing_mm.maxCoeff())
      near.push_back(edge[i]);
  if (near.empty()) return inside;
  std::nth_element(near.begin(), near.begin() + near.size() / 2, near.end());
  const float middle = std::max(near[near.size() / 2], 1e-3f);
  for (float& g : edge) g = 1 / (1 + (g / middle) * (g / middle));

  auto contour = itk::GeodesicActiveContourLevelSetImageFilter<Image, Image>::New();
  ScalarField start = inside;  // ITK: negative inside
  for (float& v : start.values) v = -v;
  contour->SetInput(itk_bridge::ToItk<float>(start.grid, start.values));
  contour->SetFeatureImage(itk_bridge::ToItk<float>(image.grid, edge));
  contour->SetPropagationScaling(0);
  contour->SetCurvatureScaling(0.3);
  contour->SetAdvectionScaling(1.0);
  contour->SetMaximumRMSError(0);
  contour->SetNumberOfIterations(static_cast<unsigned>(iterations));
  itk_bridge::Run(contour.GetPointer(), progress, "active contour");
  ScalarField out;
  out.grid = image.grid;
  out.values = itk_bridge::VoxelsOf<float>(contour->GetOutput());
  for (float& v : out.values) v = -v;
  return out;
}

}  // namespace kerf
