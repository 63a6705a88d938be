#include "Adapters/Itk/Field.h"

#include <itkBinaryFillholeImageFilter.h>
#include <itkConnectedComponentImageFilter.h>
#include <itkRelabelComponentImageFilter.h>

#include <cmath>
#include <queue>

#include "Adapters/Itk/ImageBridge.h"

namespace kerf {

using itk_bridge::Image3;

std::size_t Count(const Mask& mask) {
  return static_cast<std::size_t>(
      std::count_if(mask.values.begin(), mask.values.end(), [](std::uint8_t v) { return v != 0; }));
}

double Volume_ml(const Mask& mask) {
  return double(Count(mask)) * mask.grid.VoxelVolume_mm3() / 1000;
}

Mask AtLeast(const ScalarField& field, float threshold) {
  Mask out(field.grid, 0);
  for (std::size_t i = 0; i < out.values.size(); ++i) out.values[i] = field.values[i] >= threshold;
  return out;
}

Mask Erode(const Mask& mask, double radius_mm) {
  return AtLeast(SignedDistance_mm(mask), float(radius_mm));
}

Mask Dilate(const Mask& mask, double radius_mm) {
  return AtLeast(SignedDistance_mm(mask), -float(radius_mm));
}

Mask Open(const Mask& mask, double radius_mm) {
  Mask opened = Dilate(Erode(mask, radius_mm), radius_mm);
  for (std::size_t i = 0; i < opened.values.size(); ++i)
    opened.values[i] = opened.values[i] && mask.values[i];
  return opened;
}

Mask Close(const Mask& mask, double radius_mm) {
  Mask closed = Erode(Dilate(mask, radius_mm), radius_mm);
  for (std::size_t i = 0; i < closed.values.size(); ++i)
    closed.values[i] = closed.values[i] || mask.values[i];
  return closed;
}

Field<std::int32_t> Components(const Mask& mask, std::vector<std::size_t>* sizes) {
  using Labels = Image3<std::int32_t>;
  auto connect = itk::ConnectedComponentImageFilter<Image3<std::uint8_t>, Labels>::New();
  connect->SetInput(itk_bridge::ToItk<std::uint8_t>(mask.grid, mask.values));
  auto relabel = itk::RelabelComponentImageFilter<Labels, Labels>::New();
  relabel->SetInput(connect->GetOutput());
  relabel->Update();
  Field<std::int32_t> out;
  out.grid = mask.grid;
  out.values = itk_bridge::VoxelsOf<std::int32_t>(relabel->GetOutput());
  if (sizes) {
    sizes->clear();
    for (const auto size : relabel->GetSizeOfObjectsInPixels()) sizes->push_back(size);
  }
  return out;
}

Mask LargestComponent(const Mask& mask) {
  const auto components = Components(mask, nullptr);
  Mask out(mask.grid, 0);
  for (std::size_t i = 0; i < out.values.size(); ++i) out.values[i] = components.values[i] == 1;
  return out;
}

Mask FillHoles(const Mask& mask, int* filled) {
  auto filter = itk::BinaryFillholeImageFilter<Image3<std::uint8_t>>::New();
  filter->SetInput(itk_bridge::ToItk<std::uint8_t>(mask.grid, mask.values));
  filter->SetForegroundValue(1);
  filter->Update();
  Mask out;
  out.grid = mask.grid;
  out.values = itk_bridge::VoxelsOf<std::uint8_t>(filter->GetOutput());
  if (filled) {
    Mask holes(mask.grid, 0);
    for (std::size_t i = 0; i < out.values.size(); ++i)
      holes.values[i] = out.values[i] && !mask.values[i];
    std::vector<std::size_t> sizes;
    Components(holes, &sizes);
    *filled = static_cast<int>(sizes.size());
  }
  return out;
}

Mask GeodesicGrow(const Mask& from, const Mask& within, double reach_mm) {
  const auto& size = from.grid.size;
  const std::ptrdiff_t stride[3] = {1, size[0], std::ptrdiff_t(size[0]) * size[1]};
  std::vector<float> reached(from.values.size(), 1e9f);
  using Entry = std::pair<float, std::size_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<Entry>> front;
  for (std::size_t i = 0; i < from.values.size(); ++i)
    if (from.values[i]) {
      reached[i] = 0;
      front.push({0.f, i});
    }
  Mask out = from;
  while (!front.empty()) {
    const auto [distance, at] = front.top();
    front.pop();
    if (distance > reached[at]) continue;
    out.values[at] = 1;
    const int index[3] = {int(at % size[0]), int(at / size[0] % size[1]),
                          int(at / (std::size_t(size[0]) * size[1]))};
    for (int axis = 0; axis < 3; ++axis)
      for (const int step : {-1, 1}) {
        const int next = index[axis] + step;
        if (next < 0 || next >= size[axis]) continue;
        const std::size_t to = std::size_t(std::ptrdiff_t(at) + step * stride[axis]);
        const float d = distance + float(from.grid.spacing_mm[axis]);
        if (!within.values[to] || d > reach_mm || d >= reached[to]) continue;
        reached[to] = d;
        front.push({d, to});
      }
  }
  return out;
}

}  // namespace kerf
