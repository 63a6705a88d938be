#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>

/// Inside this component only.
namespace kerf {

/// Picture size that an encoded packet announces: the sequence parameter set of H.264 (Annex B),
/// the frame header of JPEG. None where the packet says nothing (most do not). OpenCV scales every
/// picture to the size of the first without a word, so a change of size can be seen only here.
/// @return width and height, px
std::optional<std::pair<int, int>> EncodedSize(const std::uint8_t* packet, std::size_t bytes);

}  // namespace kerf
