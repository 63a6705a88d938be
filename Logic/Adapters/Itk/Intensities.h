#pragma once

#include <memory>
#include <string>
#include <vector>

#include "Core/Progress.h"
#include "Core/Volume.h"

namespace kerf {

/// Collects voxel values as int16 HU: rounds, clamps, counts what is no number.
class HounsfieldBuilder {
 public:
  HounsfieldBuilder(std::string source, const GridGeometry& grid);
  void Append(const std::vector<float>& values);
  void Append(const float* values, std::size_t count);
  /// Warns of what was clamped and of values that do not look like a CT's. @throws InputError when
  /// there are fewer or more values than voxels, or all voxels are the same
  std::shared_ptr<const std::vector<std::int16_t>> Finish(Progress& progress);

 private:
  std::string source_;
  std::size_t expected_;
  std::shared_ptr<std::vector<std::int16_t>> voxels_;
  std::size_t clamped_ = 0, not_numbers_ = 0;
};

}  // namespace kerf
