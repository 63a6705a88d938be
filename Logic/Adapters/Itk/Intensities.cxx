#include "Adapters/Itk/Intensities.h"

#include <algorithm>
#include <cmath>

#include "Core/Errors.h"

namespace kerf {

HounsfieldBuilder::HounsfieldBuilder(std::string source, const GridGeometry& grid)
    : source_(std::move(source)),
      expected_(grid.VoxelCount()),
      voxels_(std::make_shared<std::vector<std::int16_t>>()) {
  voxels_->reserve(expected_);
}

void HounsfieldBuilder::Append(const std::vector<float>& values) {
  Append(values.data(), values.size());
}

void HounsfieldBuilder::Append(const float* values, std::size_t count) {
  constexpr float kLeast = -32768, kMost = 32767;
  for (std::size_t i = 0; i < count; ++i) {
    float value = values[i];
    if (std::isnan(value)) {
      ++not_numbers_;
      value = -1024;  // resampling programs pad with NaN: outside the scan, thus air
    } else if (value < kLeast || value > kMost) {
      ++clamped_;
      value = std::clamp(value, kLeast, kMost);
    }
    voxels_->push_back(static_cast<std::int16_t>(std::lround(value)));
  }
}

std::shared_ptr<const std::vector<std::int16_t>> HounsfieldBuilder::Finish(Progress& progress) {
  if (voxels_->size() != expected_)
    throw InputError(
        source_, "voxels",
        std::to_string(voxels_->size()) + " values for " + std::to_string(expected_) + " voxels");
  if (not_numbers_ == expected_) throw InputError(source_, "voxels", "none is a number");
  if (not_numbers_ > 0)
    progress.Warn(source_ + ": " + std::to_string(not_numbers_) +
                  " voxels are not numbers and were taken as air");
  if (clamped_ > 0)
    progress.Warn(source_ + ": " + std::to_string(clamped_) +
                  " voxels do not fit 16 bits and were clamped");
  const auto [low, high] = std::minmax_element(voxels_->begin(), voxels_->end());
  if (*low == *high)
    throw InputError(source_, "voxels", "all are " + std::to_string(*low) + ": an empty image");
  if (*low > -150 || *high < 20)
    progress.Warn(source_ + ": values from " + std::to_string(*low) + " to " +
                  std::to_string(*high) + " do not look like Hounsfield units with air and tissue");
  return voxels_;
}

}  // namespace kerf
