#include "Adapters/Rendering/ImageEncoding.h"

#include <vtkImageData.h>
#include <vtkImageWriter.h>
#include <vtkJPEGWriter.h>
#include <vtkNew.h>
#include <vtkPNGReader.h>
#include <vtkPNGWriter.h>
#include <vtkUnsignedCharArray.h>

#include <fstream>

#include "Core/Errors.h"

namespace kerf {
namespace {

// VTK's rows go up and its colours are RGB.
void ToVtk(const Image& image, vtkImageData* out) {
  out->SetDimensions(image.width, image.height, 1);
  out->AllocateScalars(VTK_UNSIGNED_CHAR, image.channels);
  for (int y = 0; y < image.height; ++y) {
    auto* to = static_cast<std::uint8_t*>(out->GetScalarPointer(0, image.height - 1 - y, 0));
    const std::uint8_t* from = image.data.data() + std::size_t(y) * image.width * image.channels;
    for (int x = 0; x < image.width; ++x)
      for (int k = 0; k < image.channels; ++k)
        to[x * image.channels + k] = from[x * image.channels + image.channels - 1 - k];
  }
}

template <class Writer>
std::vector<std::uint8_t> Encode(const Image& image, Writer* writer) {
  vtkNew<vtkImageData> data;
  ToVtk(image, data);
  writer->SetInputData(data);
  writer->WriteToMemoryOn();
  writer->Write();
  vtkUnsignedCharArray* bytes = writer->GetResult();
  return {bytes->GetPointer(0), bytes->GetPointer(0) + bytes->GetNumberOfValues()};
}

}  // namespace

std::vector<std::uint8_t> EncodePng(const Image& image, int compression) {
  vtkNew<vtkPNGWriter> writer;
  writer->SetCompressionLevel(compression);
  return Encode(image, writer.Get());
}

std::vector<std::uint8_t> EncodeJpeg(const Image& image, int quality) {
  vtkNew<vtkJPEGWriter> writer;
  writer->SetQuality(quality);
  return Encode(image, writer.Get());
}

void WritePng(const std::string& file, const Image& image, int compression) {
  const std::vector<std::uint8_t> bytes = EncodePng(image, compression);
  std::ofstream out(file, std::ios::binary);
  out.write(reinterpret_cast<const char*>(bytes.data()),
            static_cast<std::streamsize>(bytes.size()));
  if (!out.flush()) throw InputError(file, "", "cannot be written");
}

Image ReadPng(const std::string& file) {
  vtkNew<vtkPNGReader> reader;
  if (!std::ifstream(file) || !reader->CanReadFile(file.c_str()))
    throw InputError(file, "", "is no readable PNG");
  reader->SetFileName(file.c_str());
  reader->Update();
  vtkImageData* data = reader->GetOutput();
  int dims[3];
  data->GetDimensions(dims);
  const int from_channels = data->GetNumberOfScalarComponents();
  Image image;
  image.width = dims[0];
  image.height = dims[1];
  image.channels = from_channels >= 3 ? 3 : 1;
  if (data->GetScalarType() != VTK_UNSIGNED_CHAR)
    throw InputError(file, "", "has more than 8 bits per channel");
  image.data.resize(std::size_t(dims[0]) * dims[1] * image.channels);
  for (int y = 0; y < dims[1]; ++y) {
    const auto* from =
        static_cast<const std::uint8_t*>(data->GetScalarPointer(0, dims[1] - 1 - y, 0));
    for (int x = 0; x < dims[0]; ++x)
      for (int k = 0; k < image.channels; ++k)
        image.data[(std::size_t(y) * dims[0] + x) * image.channels + k] =
            from[x * from_channels + image.channels - 1 - k];
  }
  return image;
}

}  // namespace kerf
