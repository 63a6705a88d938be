#include "Adapters/Itk/VolumeFiles.h"

#include <itkImageFileReader.h>
#include <itkImageFileWriter.h>
#include <itkObjectFactoryBase.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "Adapters/Itk/DicomFolder.h"
#include "Adapters/Itk/FileKinds.h"
#include "Adapters/Itk/ImageBridge.h"
#include "Adapters/Itk/Intensities.h"
#include "Adapters/Itk/RawHeader.h"
#include "Core/Errors.h"

namespace kerf {
namespace {

using itk_bridge::Image3;

/// Header checked by us, voxels read by ITK.
Image3<float>::Pointer ReadImage(const std::string& path, Progress& progress) {
  CheckIsFile(path);
  const FileKind kind = KindOf(path);
  if (kind == FileKind::Nifti) CheckNiftiHeader(path, progress);
  if (kind == FileKind::Nrrd) CheckNrrdHeader(path, false, progress);
  if (kind == FileKind::MetaImage) CheckMetaImageHeader(path);
  auto io = MakeImageIO(kind);
  io->SetFileName(path);
  auto reader = itk::ImageFileReader<Image3<float>>::New();
  reader->SetFileName(path);
  reader->SetImageIO(io);
  try {
    io->ReadImageInformation();
    if (io->GetNumberOfComponents() != 1)
      throw InputError(path, "components", "a colour or vector image is no CT");
    itk_bridge::Run(reader.GetPointer(), progress, "reading the volume");
  } catch (const itk::ExceptionObject& error) {
    throw InputError(path, "", "cannot be read: " + itk_bridge::ReasonOf(error));
  }
  return reader->GetOutput();
}

template <class TPixel, class TVoxel>
void Write(const std::string& path, const GridGeometry& grid, const std::vector<TVoxel>& voxels) {
  grid.Validate(path);
  if (voxels.size() != grid.VoxelCount())
    throw InputError(path, "voxels", "their number does not fit the grid");
  const auto image = itk_bridge::ToItk<TPixel>(grid, voxels);
  WriteImage(path, image.GetPointer());
}

}  // namespace

Volume ReadVolume(const std::string& path, const VolumeReadOptions& options, Progress& progress) {
  if (!std::filesystem::exists(path)) throw InputError(path, "", "does not exist");
  if (std::filesystem::is_directory(path)) return ReadDicomFolder(path, options.series, progress);
  if (!options.series.empty())
    throw UsageError("a series can be chosen in a DICOM folder only, " + path + " is a file");
  const auto image = ReadImage(path, progress);
  Volume volume;
  volume.source = path;
  volume.grid = itk_bridge::GetGeometry(image.GetPointer());
  volume.grid.Validate(path);
  HounsfieldBuilder voxels(path, volume.grid);
  voxels.Append(image->GetBufferPointer(), volume.grid.VoxelCount());
  volume.voxels = voxels.Finish(progress);
  volume.metadata["modality"] = "CT";
  return volume;
}

Volume ReadVolume(const std::string& path) {
  Progress silent;
  return ReadVolume(path, {}, silent);
}

LabelMap ReadLabelMap(const std::string& path) {
  if (KindOf(path) == FileKind::SegNrrd) return ReadSegmentation(path);
  Progress silent;
  const auto image = ReadImage(path, silent);
  LabelMap labels;
  labels.source = path;
  labels.grid = itk_bridge::GetGeometry(image.GetPointer());
  labels.grid.Validate(path);
  auto voxels = std::make_shared<std::vector<std::uint8_t>>(labels.grid.VoxelCount());
  const float* values = image->GetBufferPointer();
  for (std::size_t i = 0; i < voxels->size(); ++i) {
    const float value = values[i];
    if (!(value >= 0 && value <= 255) || value != std::floor(value))
      throw InputError(path, "voxel " + std::to_string(i),
                       "is " + std::to_string(value) + ": labels are integers from 0 to 255");
    (*voxels)[i] = static_cast<std::uint8_t>(value);
  }
  labels.voxels = std::move(voxels);
  labels.names = {{1, "organ"}, {2, "tumour"}, {3, "internal"}};
  return labels;
}

void WriteVolume(const std::string& path, const Volume& volume) {
  Write<std::int16_t>(path, volume.grid, *volume.voxels);
}

void WriteLabelMap(const std::string& path, const LabelMap& labels) {
  if (KindOf(path) == FileKind::SegNrrd) {
    WriteSegmentation(path, labels);
    return;
  }
  Write<std::uint8_t>(path, labels.grid, *labels.voxels);
}

void InitializeItk() { itk::ObjectFactoryBase::GetRegisteredFactories(); }

}  // namespace kerf
