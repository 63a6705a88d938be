#pragma once

#include <itkCommand.h>
#include <itkImage.h>
#include <itkImportImageFilter.h>
#include <itkProcessObject.h>

#include <cstring>
#include <sstream>
#include <string>

#include "Core/Progress.h"
#include "Core/Volume.h"

/// ITK ↔ Kerf, for the sources of this component only: no public header includes ITK. Both are LPS.
namespace kerf::itk_bridge {

/// What ITK has to say, in one line: the innermost reason, which comes last, without ITK's class
/// and address and without the function of a library that found it.
inline std::string ReasonOf(const itk::ExceptionObject& error) {
  std::istringstream lines(error.GetDescription());
  std::string line, reason;
  while (std::getline(lines, line))
    if (line.find_first_not_of(" \t\r") != std::string::npos) reason = line;
  const bool of_library = reason.rfind("[nrrd]", 0) == 0;
  const char* const before = of_library ? ": " : "): ";
  const std::size_t at = reason.find(before);
  if (at != std::string::npos) reason.erase(0, at + std::strlen(before));
  return reason;
}

template <class T>
using Image3 = itk::Image<T, 3>;

template <class TImage>
void SetGeometry(TImage* image, const GridGeometry& grid) {
  typename TImage::SpacingType spacing;
  typename TImage::PointType origin;
  typename TImage::DirectionType direction;
  typename TImage::RegionType region;
  for (int a = 0; a < 3; ++a) {
    spacing[a] = grid.spacing_mm[a];
    origin[a] = grid.origin_mm[a];
    region.SetSize(a, grid.size[a]);
    region.SetIndex(a, 0);
    for (int b = 0; b < 3; ++b) direction(a, b) = grid.direction(a, b);
  }
  image->SetSpacing(spacing);
  image->SetOrigin(origin);
  image->SetDirection(direction);
  image->SetRegions(region);
}

template <class TImage>
GridGeometry GetGeometry(const TImage* image) {
  GridGeometry grid;
  const auto region = image->GetLargestPossibleRegion();
  typename TImage::PointType first;
  image->TransformIndexToPhysicalPoint(region.GetIndex(), first);
  for (int a = 0; a < 3; ++a) {
    grid.size[a] = static_cast<int>(region.GetSize(a));
    grid.spacing_mm[a] = image->GetSpacing()[a];
    grid.origin_mm[a] = first[a];
    for (int b = 0; b < 3; ++b) grid.direction(a, b) = image->GetDirection()(a, b);
  }
  return grid;
}

/// A new ITK image with a copy of the voxels, converted.
template <class TPixel, class TVoxel>
typename Image3<TPixel>::Pointer ToItk(const GridGeometry& grid,
                                       const std::vector<TVoxel>& voxels) {
  auto image = Image3<TPixel>::New();
  SetGeometry(image.GetPointer(), grid);
  image->Allocate();
  TPixel* out = image->GetBufferPointer();
  for (std::size_t i = 0; i < voxels.size(); ++i) out[i] = static_cast<TPixel>(voxels[i]);
  return image;
}

template <class TVoxel, class TImage>
std::vector<TVoxel> VoxelsOf(const TImage* image) {
  const std::size_t n = image->GetLargestPossibleRegion().GetNumberOfPixels();
  const auto* in = image->GetBufferPointer();
  std::vector<TVoxel> out(n);
  for (std::size_t i = 0; i < n; ++i) out[i] = static_cast<TVoxel>(in[i]);
  return out;
}

/// Runs a filter; reports its progress and passes the user's cancel on to it. @throws Cancelled
template <class TFilter>
void Run(TFilter* filter, Progress& progress, const char* what) {
  progress.ThrowIfCancelled();
  auto command = itk::CStyleCommand::New();
  struct Context {
    Progress* progress;
    const char* what;
  } context{&progress, what};
  command->SetClientData(&context);
  command->SetCallback([](itk::Object* caller, const itk::EventObject&, void* data) {
    auto* c = static_cast<Context*>(data);
    auto* process = static_cast<itk::ProcessObject*>(caller);
    c->progress->Report(process->GetProgress(), c->what);
    if (c->progress->IsCancelled()) process->AbortGenerateDataOn();
  });
  const auto tag = filter->AddObserver(itk::ProgressEvent(), command);
  try {
    filter->Update();
  } catch (const itk::ProcessAborted&) {
    throw Cancelled();
  }
  filter->RemoveObserver(tag);
  progress.ThrowIfCancelled();
}

}  // namespace kerf::itk_bridge
