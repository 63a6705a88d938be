#include "Adapters/Itk/DicomHeaders.h"

#include <gdcmAttribute.h>
#include <gdcmReader.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>

#include "Adapters/Itk/DicomPhase.h"
#include "Adapters/Itk/DicomStructure.h"
#include "Core/Errors.h"

namespace kerf {
namespace {

const gdcm::Tag kPixelData(0x7fe0, 0x0010);

std::string Text(const gdcm::DataSet& data, std::uint16_t group, std::uint16_t element) {
  const gdcm::Tag tag(group, element);
  if (!data.FindDataElement(tag)) return {};
  const gdcm::ByteValue* bytes = data.GetDataElement(tag).GetByteValue();
  if (!bytes) return {};
  std::string text(bytes->GetPointer(), bytes->GetLength());
  const auto last = text.find_last_not_of(std::string(" \0\t\r\n", 5));
  text.resize(last == std::string::npos ? 0 : last + 1);
  text.erase(0, std::min(text.find_first_not_of(' '), text.size()));
  return text;
}

/// Decimal strings "a\b\c". @throws InputError when one of them is no finite number
std::vector<double> Decimals(const gdcm::DataSet& data, std::uint16_t group, std::uint16_t element,
                             const std::string& path, const std::string& name) {
  std::vector<double> values;
  const std::string text = Text(data, group, element);
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\\', begin), text.size());
    const std::string part = text.substr(begin, end - begin);
    char* rest = nullptr;
    const double value = std::strtod(part.c_str(), &rest);
    // A decimal comma would be read as a whole number, and what follows it be lost.
    if (rest == part.c_str() ||
        part.find_first_not_of(" ", rest - part.c_str()) != std::string::npos ||
        !std::isfinite(value))
      throw InputError(path, name, "'" + part + "' is not a number");
    values.push_back(value);
    begin = end + 1;
  }
  return values;
}

int Unsigned(const gdcm::DataSet& data, std::uint16_t group, std::uint16_t element, int otherwise) {
  const gdcm::Tag tag(group, element);
  if (!data.FindDataElement(tag)) return otherwise;
  const gdcm::ByteValue* bytes = data.GetDataElement(tag).GetByteValue();
  if (!bytes || bytes->GetLength() < 2) return otherwise;
  std::uint16_t value = 0;
  bytes->GetBuffer(reinterpret_cast<char*>(&value), 2);
  return value;
}

/// Integer string. Nothing where it is absent or no number: no voxel's place hangs on those.
std::optional<int> Integer(const gdcm::DataSet& data, std::uint16_t group, std::uint16_t element) {
  const std::string text = Text(data, group, element);
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

/// Names come padded and with empty components at the end: those do not make another patient.
std::string NormalizedName(std::string name) {
  for (char& c : name) c = c == '^' ? ' ' : static_cast<char>(std::toupper(c));
  const auto last = name.find_last_not_of(' ');
  name.resize(last == std::string::npos ? 0 : last + 1);
  return name;
}

/// @return nothing for a file that is no DICOM image
std::optional<DicomSlice> ReadHeader(const std::string& path) {
  if (!CheckDicomStructure(path)) return std::nullopt;
  gdcm::Reader reader;
  reader.SetFileName(path.c_str());
  bool read = false;
  try {
    read = reader.ReadUpToTag(kPixelData);
  } catch (const std::exception&) {
  }
  if (!read) throw InputError(path, "header", "breaks off or is damaged");
  const gdcm::DataSet& data = reader.GetFile().GetDataSet();
  const std::string storage = Text(reader.GetFile().GetHeader(), 0x0002, 0x0002);
  if (storage == "1.2.840.10008.1.3.10") return std::nullopt;  // DICOMDIR

  DicomSlice slice;
  slice.path = path;
  slice.rows = Unsigned(data, 0x0028, 0x0010, 0);
  slice.columns = Unsigned(data, 0x0028, 0x0011, 0);
  if (slice.rows == 0 || slice.columns == 0) {
    // Reports, presentation states, segmentation objects: DICOM, but no image of this kind.
    return std::nullopt;
  }
  slice.samples = Unsigned(data, 0x0028, 0x0002, 1);
  slice.photometric = Text(data, 0x0028, 0x0004);
  slice.bits = Unsigned(data, 0x0028, 0x0100, 16);
  const std::string frames = Text(data, 0x0028, 0x0008);
  slice.frames = frames.empty() ? 1 : std::atoi(frames.c_str());
  const std::string identity = Text(data, 0x0010, 0x0020) + "|" +
                               NormalizedName(Text(data, 0x0010, 0x0010)) + "|" +
                               Text(data, 0x0010, 0x0030);
  if (identity != "||") slice.patient_key = std::to_string(std::hash<std::string>{}(identity));
  for (const std::string& part : {PersonName(Text(data, 0x0010, 0x0010)),
                                  Text(data, 0x0010, 0x0020), Text(data, 0x0010, 0x0030)})
    if (!part.empty()) slice.patient += (slice.patient.empty() ? "" : " · ") + part;
  slice.series_uid = Text(data, 0x0020, 0x000e);
  slice.sop_uid = Text(data, 0x0008, 0x0018);
  slice.study_uid = Text(data, 0x0020, 0x000d);
  slice.frame_uid = Text(data, 0x0020, 0x0052);
  slice.description = Text(data, 0x0008, 0x103e);
  slice.series_number = Text(data, 0x0020, 0x0011);
  slice.number = Integer(data, 0x0020, 0x0013);
  slice.acquisition = Text(data, 0x0020, 0x0012);
  slice.images_in_acquisition = Integer(data, 0x0020, 0x1002).value_or(0);
  slice.images_in_series = Integer(data, 0x0020, 0x1209).value_or(0);
  slice.modality = Text(data, 0x0008, 0x0060);
  slice.image_type = Text(data, 0x0008, 0x0008);
  slice.laterality = LateralityInWords(Text(data, 0x0020, 0x0060));
  if (slice.laterality.empty()) slice.laterality = LateralityInWords(Text(data, 0x0020, 0x0062));
  slice.phase = ContrastPhase({slice.description, Text(data, 0x0018, 0x0010),
                               Text(data, 0x0018, 0x1042), Text(data, 0x0008, 0x0032)});

  const auto position = Decimals(data, 0x0020, 0x0032, path, "ImagePositionPatient (0020,0032)");
  slice.has_position = position.size() == 3;
  if (slice.has_position) slice.position_mm = Vec3(position[0], position[1], position[2]);
  const auto axes = Decimals(data, 0x0020, 0x0037, path, "ImageOrientationPatient (0020,0037)");
  slice.has_orientation = axes.size() == 6;
  if (slice.has_orientation) {
    slice.row_axis = Vec3(axes[0], axes[1], axes[2]);
    slice.column_axis = Vec3(axes[3], axes[4], axes[5]);
  }
  const auto spacing = Decimals(data, 0x0028, 0x0030, path, "PixelSpacing (0028,0030)");
  slice.has_spacing = spacing.size() == 2;
  if (slice.has_spacing) {
    slice.spacing_y_mm = spacing[0];
    slice.spacing_x_mm = spacing[1];
  }
  const auto first = [&](std::uint16_t group, std::uint16_t element, const char* name,
                         double otherwise) {
    const auto values = Decimals(data, group, element, path, name);
    return values.empty() ? otherwise : values[0];
  };
  slice.thickness_mm = first(0x0018, 0x0050, "SliceThickness (0018,0050)", 0);
  slice.tilt_deg = first(0x0018, 0x1120, "GantryDetectorTilt (0018,1120)", 0);
  slice.slope = first(0x0028, 0x1053, "RescaleSlope (0028,1053)", 1);
  slice.intercept = first(0x0028, 0x1052, "RescaleIntercept (0028,1052)", 0);
  return slice;
}

/// What ITK would take as it is, or fill in by itself.
void CheckSlice(const DicomSlice& s) {
  if (s.samples != 1)
    throw InputError(s.path, "SamplesPerPixel (0028,0002)",
                     std::to_string(s.samples) + ": a colour image is no CT");
  if (!s.photometric.empty() && s.photometric != "MONOCHROME2")
    throw InputError(s.path, "PhotometricInterpretation (0028,0004)",
                     s.photometric + ": " +
                         (s.photometric == "MONOCHROME1" ? "grey values are inverted"
                                                         : "a colour image is no CT"));
  if (s.frames > 1)
    throw InputError(s.path, "NumberOfFrames (0028,0008)",
                     std::to_string(s.frames) +
                         ": multi-frame files are not read; export single frames or NIfTI");
  if (!s.has_position)
    throw InputError(s.path, "ImagePositionPatient (0020,0032)", "missing: the slice has no place");
  if (!s.has_orientation)
    throw InputError(s.path, "ImageOrientationPatient (0020,0037)", "missing or incomplete");
  if (!s.has_spacing) throw InputError(s.path, "PixelSpacing (0028,0030)", "missing or incomplete");
  if (s.spacing_x_mm <= 0 || s.spacing_y_mm <= 0)
    throw InputError(s.path, "PixelSpacing (0028,0030)", "must be positive");
  if (std::abs(s.row_axis.norm() - 1) > 1e-2 || std::abs(s.column_axis.norm() - 1) > 1e-2 ||
      std::abs(s.row_axis.dot(s.column_axis)) > 1e-2)
    throw InputError(s.path, "ImageOrientationPatient (0020,0037)", "axes are not orthonormal");
  if (s.slope == 0) throw InputError(s.path, "RescaleSlope (0028,1053)", "must not be zero");
}

bool IsLocalizer(const DicomSlice& slice) {
  return slice.image_type.find("LOCALIZER") != std::string::npos;
}

/// One series UID can hold unlike stacks (localizers, other orientations): each is a stack of its
/// own.
bool SameStack(const DicomSlice& a, const DicomSlice& b) {
  return a.rows == b.rows && a.columns == b.columns && IsLocalizer(a) == IsLocalizer(b) &&
         (a.row_axis - b.row_axis).norm() < 1e-2 && (a.column_axis - b.column_axis).norm() < 1e-2 &&
         std::abs(a.spacing_x_mm - b.spacing_x_mm) < 1e-3 &&
         std::abs(a.spacing_y_mm - b.spacing_y_mm) < 1e-3;
}

std::vector<std::string> FilesBelow(const std::string& folder) {
  std::vector<std::string> files;
  std::error_code error;
  std::filesystem::recursive_directory_iterator it(
      folder, std::filesystem::directory_options::skip_permission_denied, error);
  if (error) throw InputError(folder, "", "cannot be listed: " + error.message());
  for (const auto& entry : it)
    if (entry.is_regular_file()) files.push_back(entry.path().string());
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace

std::vector<DicomSeries> ScanDicomFolder(const std::string& folder, Progress& progress) {
  const std::vector<std::string> files = FilesBelow(folder);
  if (files.empty()) throw InputError(folder, "", "the folder is empty");

  std::map<std::string, std::vector<DicomSeries>> stacks_of_uid;
  std::vector<std::string> ignored;
  bool no_uid = false;
  for (std::size_t i = 0; i < files.size(); ++i) {
    progress.ThrowIfCancelled();
    if (i % 16 == 0) progress.Report(double(i) / files.size(), "reading DICOM headers");
    auto slice = ReadHeader(files[i]);
    if (!slice) {
      ignored.push_back(std::filesystem::path(files[i]).filename().string());
      continue;
    }
    CheckSlice(*slice);
    no_uid =
        no_uid || slice->series_uid.empty() || slice->sop_uid.empty() || slice->study_uid.empty();
    // Without a UID the number and description are the next best thing that a scanner fills in.
    const std::string key = !slice->series_uid.empty()
                                ? slice->series_uid
                                : "~" + slice->series_number + "~" + slice->description;
    auto& stacks = stacks_of_uid[key];
    auto fit = std::find_if(stacks.begin(), stacks.end(), [&](const DicomSeries& s) {
      return SameStack(s.slices.front(), *slice);
    });
    if (fit == stacks.end()) fit = stacks.insert(stacks.end(), DicomSeries{});
    fit->slices.push_back(std::move(*slice));
  }
  if (stacks_of_uid.empty()) throw InputError(folder, "", "no DICOM image in the folder");
  if (!ignored.empty())
    progress.Warn(folder + ": " + std::to_string(ignored.size()) +
                  " file(s) that are no DICOM images were ignored (" + ignored.front() +
                  (ignored.size() > 1 ? ", …)" : ")"));
  if (no_uid)
    progress.Warn(folder +
                  ": SOP, Study or Series Instance UIDs are missing; slices were grouped by series "
                  "number, description, size and orientation");

  std::vector<DicomSeries> result;
  int unnamed = 0;
  for (auto& [key, stacks] : stacks_of_uid) {
    const std::string base = key.front() == '~' ? "no-uid-" + std::to_string(++unnamed) : key;
    // The stack with most slices keeps the plain name.
    std::stable_sort(stacks.begin(), stacks.end(), [](const DicomSeries& a, const DicomSeries& b) {
      return a.slices.size() > b.slices.size();
    });
    for (std::size_t n = 0; n < stacks.size(); ++n) {
      DicomSeries series = std::move(stacks[n]);
      series.name = n == 0 ? base : base + "#" + std::to_string(n + 1);
      const Vec3 normal = series.slices.front().Normal();
      std::stable_sort(series.slices.begin(), series.slices.end(),
                       [&](const DicomSlice& a, const DicomSlice& b) {
                         return normal.dot(a.position_mm) < normal.dot(b.position_mm);
                       });
      result.push_back(std::move(series));
    }
  }
  return result;
}

}  // namespace kerf
