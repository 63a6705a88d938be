#pragma once

#include <itkImageFileWriter.h>
#include <itkImageIOBase.h>

#include <filesystem>
#include <string>

#include "Core/Errors.h"

namespace kerf {

enum class FileKind { Nifti, Nrrd, SegNrrd, MetaImage };

/// By extension. @throws InputError naming the extensions that are known
FileKind KindOf(const std::string& path);
/// @throws InputError
void CheckIsFile(const std::string& path);
/// The one reader or writer that belongs to the extension: ITK's factory would try all.
itk::ImageIOBase::Pointer MakeImageIO(FileKind kind);
/// A name in the same folder and with the same extension, for the file while it is being written.
std::string PartialName(const std::string& path);

/// Compressed; written beside the target first, then renamed. @throws InputError
template <class TImage>
void WriteImage(const std::string& path, const TImage* image) {
  const std::string partial = PartialName(path);
  auto writer = itk::ImageFileWriter<TImage>::New();
  writer->SetImageIO(MakeImageIO(KindOf(path)));
  writer->SetFileName(partial);
  writer->SetInput(image);
  writer->UseCompressionOn();
  std::error_code error;
  try {
    writer->Update();
  } catch (const itk::ExceptionObject& exception) {
    std::filesystem::remove(partial, error);
    throw InputError(path, "", std::string("cannot be written: ") + exception.GetDescription());
  }
  std::filesystem::rename(partial, path, error);
  if (error) throw InputError(path, "", "cannot be written: " + error.message());
}

}  // namespace kerf
