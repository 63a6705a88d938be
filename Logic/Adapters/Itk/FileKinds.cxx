#include "Adapters/Itk/FileKinds.h"

#include <itkMetaImageIO.h>
#include <itkNiftiImageIO.h>
#include <itkNrrdImageIO.h>

namespace kerf {
namespace {

bool EndsWith(const std::string& text, const std::string& end) {
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

}  // namespace

FileKind KindOf(const std::string& path) {
  std::string name = std::filesystem::path(path).filename().string();
  for (char& c : name) c = static_cast<char>(std::tolower(c));
  if (EndsWith(name, ".nii") || EndsWith(name, ".nii.gz") || EndsWith(name, ".hdr"))
    return FileKind::Nifti;
  if (EndsWith(name, ".seg.nrrd")) return FileKind::SegNrrd;
  if (EndsWith(name, ".nrrd") || EndsWith(name, ".nhdr")) return FileKind::Nrrd;
  if (EndsWith(name, ".mha") || EndsWith(name, ".mhd")) return FileKind::MetaImage;
  throw InputError(path, "extension",
                   "unknown image format; .nii, .nii.gz, .nrrd, .seg.nrrd and .mha are known (a "
                   "DICOM series is given as its folder)");
}

void CheckIsFile(const std::string& path) {
  if (!std::filesystem::exists(path)) throw InputError(path, "", "does not exist");
  if (!std::filesystem::is_regular_file(path)) throw InputError(path, "", "is no file");
  if (std::filesystem::file_size(path) == 0) throw InputError(path, "", "the file is empty");
}

itk::ImageIOBase::Pointer MakeImageIO(FileKind kind) {
  if (kind == FileKind::Nifti) return itk::NiftiImageIO::New().GetPointer();
  if (kind == FileKind::MetaImage) return itk::MetaImageIO::New().GetPointer();
  return itk::NrrdImageIO::New().GetPointer();
}

std::string PartialName(const std::string& path) {
  const std::filesystem::path target(path);
  return (target.parent_path() / (".partial-" + target.filename().string())).string();
}

}  // namespace kerf
