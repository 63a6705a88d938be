#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "Core/Frame.h"

namespace kerf {

/// PNG (lossless) or JPEG (quality 1..100) file contents. No display is needed.
/// @param compression 0..9: 1 takes a third of the time of 5 and a little more room
std::vector<std::uint8_t> EncodePng(const Image& image, int compression = 5);
std::vector<std::uint8_t> EncodeJpeg(const Image& image, int quality = 85);
/// @throws InputError naming the file when it can't be written or read
void WritePng(const std::string& file, const Image& image, int compression = 5);
Image ReadPng(const std::string& file);

}  // namespace kerf
