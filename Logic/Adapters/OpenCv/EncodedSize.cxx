#include "Adapters/OpenCv/EncodedSize.h"

#include <algorithm>
#include <vector>

namespace kerf {
namespace {

/// Bits of a NAL unit, emulation prevention bytes removed; reading past the end gives zeros and is
/// remembered.
class BitReader {
 public:
  BitReader(const std::uint8_t* data, std::size_t bytes) {
    for (std::size_t i = 0; i < bytes; ++i) {
      if (i >= 2 && data[i] == 3 && data[i - 1] == 0 && data[i - 2] == 0) continue;
      bytes_.push_back(data[i]);
    }
  }
  unsigned Bits(int count) {
    unsigned value = 0;
    for (int k = 0; k < count; ++k, ++position_) {
      const std::size_t byte = position_ / 8;
      if (byte >= bytes_.size()) exhausted_ = true;
      const unsigned bit = exhausted_ ? 0U : (bytes_[byte] >> (7 - position_ % 8)) & 1U;
      value = value << 1 | bit;
    }
    return value;
  }
  /// Exponential Golomb codes, unsigned and signed.
  unsigned Golomb() {
    int zeros = 0;
    while (!exhausted_ && zeros < 31 && Bits(1) == 0) ++zeros;
    return (1U << zeros) - 1 + Bits(zeros);
  }
  int SignedGolomb() {
    const unsigned code = Golomb();
    return code % 2 ? static_cast<int>(code / 2 + 1) : -static_cast<int>(code / 2);
  }
  bool Exhausted() const { return exhausted_; }

 private:
  std::vector<std::uint8_t> bytes_;
  std::size_t position_ = 0;
  bool exhausted_ = false;
};

void SkipScalingList(BitReader& bits, int entries) {
  int last = 8, next = 8;
  for (int k = 0; k < entries && !bits.Exhausted(); ++k) {
    if (next != 0) next = (last + bits.SignedGolomb() + 256) % 256;
    last = next == 0 ? last : next;
  }
}

/// ITU-T H.264, 7.3.2.1.1, up to the cropping.
std::optional<std::pair<int, int>> SizeOfParameterSet(const std::uint8_t* data, std::size_t bytes) {
  BitReader bits(data, bytes);
  const unsigned profile = bits.Bits(8);
  bits.Bits(16);  // constraints, level
  bits.Golomb();  // id
  unsigned chroma = 1;
  bool separate_planes = false;
  for (const unsigned high :
       {100U, 110U, 122U, 244U, 44U, 83U, 86U, 118U, 128U, 138U, 139U, 134U, 135U}) {
    if (profile != high) continue;
    chroma = bits.Golomb();
    if (chroma == 3) separate_planes = bits.Bits(1) != 0;
    bits.Golomb();  // bit depths
    bits.Golomb();
    bits.Bits(1);
    if (bits.Bits(1))
      for (int k = 0; k < (chroma == 3 ? 12 : 8); ++k)
        if (bits.Bits(1)) SkipScalingList(bits, k < 6 ? 16 : 64);
  }
  bits.Golomb();  // frame numbers
  const unsigned order = bits.Golomb();
  if (order == 0) {
    bits.Golomb();
  } else if (order == 1) {
    bits.Bits(1);
    bits.SignedGolomb();
    bits.SignedGolomb();
    const unsigned cycle = bits.Golomb();
    for (unsigned k = 0; k < cycle && !bits.Exhausted(); ++k) bits.SignedGolomb();
  }
  bits.Golomb();  // reference frames
  bits.Bits(1);
  const int columns = static_cast<int>(bits.Golomb()) + 1;
  const int rows = static_cast<int>(bits.Golomb()) + 1;
  const int fields = bits.Bits(1) ? 1 : 2;
  if (fields == 2) bits.Bits(1);
  bits.Bits(1);
  int width = 16 * columns, height = 16 * rows * fields;
  if (bits.Bits(1)) {
    const bool subsampled_x = !separate_planes && (chroma == 1 || chroma == 2);
    const bool subsampled_y = !separate_planes && chroma == 1;
    const int unit_x = subsampled_x ? 2 : 1, unit_y = (subsampled_y ? 2 : 1) * fields;
    const int left = static_cast<int>(bits.Golomb()), right = static_cast<int>(bits.Golomb());
    const int top = static_cast<int>(bits.Golomb()), bottom = static_cast<int>(bits.Golomb());
    width -= unit_x * (left + right);
    height -= unit_y * (top + bottom);
  }
  if (bits.Exhausted() || width <= 0 || height <= 0) return std::nullopt;
  return std::make_pair(width, height);
}

std::optional<std::pair<int, int>> SizeOfJpeg(const std::uint8_t* data, std::size_t bytes) {
  std::size_t i = 2;
  while (i + 9 < bytes && data[i] == 0xFF) {
    const int marker = data[i + 1];
    const bool frame =
        marker >= 0xC0 && marker <= 0xCF && marker != 0xC4 && marker != 0xC8 && marker != 0xCC;
    if (frame)
      return std::make_pair(data[i + 7] << 8 | data[i + 8], data[i + 5] << 8 | data[i + 6]);
    i += 2 + (static_cast<std::size_t>(data[i + 2]) << 8 | data[i + 3]);
  }
  return std::nullopt;
}

}  // namespace

std::optional<std::pair<int, int>> EncodedSize(const std::uint8_t* packet, std::size_t bytes) {
  if (bytes > 4 && packet[0] == 0xFF && packet[1] == 0xD8 && packet[2] == 0xFF)
    return SizeOfJpeg(packet, bytes);
  for (std::size_t i = 0; i + 8 < bytes; ++i) {
    if (packet[i] != 0 || packet[i + 1] != 0 || packet[i + 2] != 1) continue;
    const int type = packet[i + 3] & 0x1F;
    if (type == 7 && (packet[i + 3] & 0x80) == 0)
      return SizeOfParameterSet(packet + i + 4, std::min<std::size_t>(bytes - i - 4, 512));
    if (type >= 1 && type <= 5) break;  // the picture itself: parameter sets come before it
    i += 2;
  }
  return std::nullopt;
}

}  // namespace kerf
