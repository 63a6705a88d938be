#pragma once

#include <algorithm>
#include <cstdint>

namespace kerf {

/// The edge a–b as one number: ascending keys are ascending by the lower end, then by the higher.
inline std::uint64_t EdgeKey(int a, int b) {
  return std::uint64_t(std::uint32_t(std::min(a, b))) << 32 | std::uint32_t(std::max(a, b));
}

}  // namespace kerf
