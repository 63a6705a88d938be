#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "Core/Frame.h"

namespace kerf {

/// PNG (lossless) or JPEG (quality 1..100) file contents. No display is needed.
std::vector<std::uint8_t> EncodePng(const Image& image);
std::vector<std::uint8_t> EncodeJpeg(const Image& image, int quality = 85);
/// @throws InputError naming the file when it can't be written or read
void WritePng(const std::string& file, const Image& image);
Image ReadPng(const std::string& file);

}  // namespace kerf
