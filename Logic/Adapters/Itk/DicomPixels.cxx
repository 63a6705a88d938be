#include <gdcmImage.h>
#include <gdcmImageReader.h>
#include <gdcmSequenceOfFragments.h>

#include <cstring>

#include "Adapters/Itk/DicomHeaders.h"
#include "Core/Errors.h"

namespace kerf {
namespace {

/// The decoders pad what is missing: look at the data's length (or end mark) first.
void CheckComplete(const gdcm::File& file, const DicomSlice& slice) {
  const std::string element = "PixelData (7FE0,0010)";
  const gdcm::Tag tag(0x7fe0, 0x0010);
  const gdcm::DataSet& data = file.GetDataSet();
  if (!data.FindDataElement(tag) || data.GetDataElement(tag).IsEmpty())
    throw InputError(slice.path, element, "missing: the file breaks off or holds no image");
  const gdcm::DataElement& pixels = data.GetDataElement(tag);
  if (const gdcm::ByteValue* bytes = pixels.GetByteValue()) {
    const std::size_t needed = std::size_t(slice.rows) * slice.columns * ((slice.bits + 7) / 8);
    if (bytes->GetLength() < needed)
      throw InputError(slice.path, element,
                       "the slice is truncated: " + std::to_string(bytes->GetLength()) + " of " +
                           std::to_string(needed) + " bytes");
  } else if (const gdcm::SequenceOfFragments* fragments = pixels.GetSequenceOfFragments()) {
    const std::string syntax = file.GetHeader().GetDataSetTransferSyntax().GetString();
    if (fragments->GetNumberOfFragments() == 0)
      throw InputError(slice.path, element, "the slice is truncated: no compressed data");
    const gdcm::ByteValue* last =
        fragments->GetFragment(fragments->GetNumberOfFragments() - 1).GetByteValue();
    const bool jpeg_family = syntax.rfind("1.2.840.10008.1.2.4.", 0) == 0;
    if (!last || last->GetLength() < 2)
      throw InputError(slice.path, element, "the slice is truncated: empty compressed data");
    if (jpeg_family) {
      // JPEG, JPEG-LS and JPEG 2000 streams all end with FF D9, padded to an even length.
      std::size_t end = last->GetLength();
      const auto* p = reinterpret_cast<const unsigned char*>(last->GetPointer());
      while (end > 2 && p[end - 1] == 0) --end;
      if (p[end - 2] != 0xff || p[end - 1] != 0xd9)
        throw InputError(slice.path, element,
                         "the slice is truncated: the compressed data have no end mark");
    }
  }
}

template <class T>
std::vector<float> Rescaled(const std::vector<char>& raw, const gdcm::PixelFormat& format,
                            const DicomSlice& slice) {
  std::vector<float> out(raw.size() / sizeof(T));
  const int stored = format.GetBitsStored();
  const int shift = format.GetHighBit() + 1 - stored;
  const std::uint64_t mask = stored >= 64 ? ~0ull : (1ull << stored) - 1;
  const std::uint64_t sign = 1ull << (stored - 1);
  for (std::size_t i = 0; i < out.size(); ++i) {
    T value;
    std::memcpy(&value, raw.data() + i * sizeof(T), sizeof(T));
    // Bits above the stored ones may carry overlays; those of a negative value are set again.
    std::int64_t bits = static_cast<std::int64_t>((std::uint64_t(value) >> shift) & mask);
    if (format.GetPixelRepresentation() == 1 && (std::uint64_t(bits) & sign))
      bits -= static_cast<std::int64_t>(mask) + 1;
    out[i] = static_cast<float>(double(bits) * slice.slope + slice.intercept);
  }
  return out;
}

}  // namespace

std::vector<float> ReadDicomPixels(const DicomSlice& slice) {
  const std::string element = "PixelData (7FE0,0010)";
  gdcm::ImageReader reader;
  reader.SetFileName(slice.path.c_str());
  bool read = false;
  try {
    read = reader.Read();
  } catch (const std::exception&) {
  }
  if (!read) throw InputError(slice.path, element, "truncated or damaged: it cannot be read");
  CheckComplete(reader.GetFile(), slice);
  const gdcm::Image& image = reader.GetImage();
  std::vector<char> raw(image.GetBufferLength());
  if (raw.empty() || !image.GetBuffer(raw.data()))
    throw InputError(slice.path, element, "cannot be decoded (truncated or damaged)");
  const gdcm::PixelFormat& format = image.GetPixelFormat();
  std::vector<float> values;
  switch (format.GetBitsAllocated()) {
    case 8:
      values = Rescaled<std::uint8_t>(raw, format, slice);
      break;
    case 16:
      values = Rescaled<std::uint16_t>(raw, format, slice);
      break;
    case 32:
      values = Rescaled<std::uint32_t>(raw, format, slice);
      break;
    default:
      throw InputError(slice.path, "BitsAllocated (0028,0100)",
                       std::to_string(format.GetBitsAllocated()) + " is not supported");
  }
  if (values.size() != std::size_t(slice.rows) * slice.columns)
    throw InputError(slice.path, element, "does not hold rows × columns values");
  return values;
}

}  // namespace kerf
