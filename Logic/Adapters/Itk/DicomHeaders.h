#pragma once

#include <optional>
#include <string>
#include <vector>

#include "Core/Progress.h"
#include "Core/Types.h"

namespace kerf {

/// What the reader needs of one DICOM image file. The patient's identity is a digest: enough to
/// tell two patients apart. `patient` is for the eyes of the person who chooses a series; it goes
/// into no message, file or journal.
struct DicomSlice {
  std::string path;
  std::string patient_key;  ///< digest of PatientID, name and birth date; empty where all three are
  std::string series_uid, sop_uid, study_uid, frame_uid, description, modality, image_type;
  std::string photometric;                                ///< MONOCHROME2 is what is read
  std::string series_number, patient, laterality, phase;  ///< the last three: SeriesInfo
  std::optional<int> number;                              ///< InstanceNumber
  std::string acquisition;                                ///< AcquisitionNumber
  int images_in_acquisition = 0, images_in_series = 0;    ///< as stated; 0 where absent
  int rows = 0, columns = 0, samples = 1, frames = 1, bits = 16;
  bool has_position = false, has_orientation = false, has_spacing = false;
  Vec3 position_mm = Vec3::Zero();
  Vec3 row_axis = Vec3::UnitX(), column_axis = Vec3::UnitY();  ///< along a row, along a column
  double spacing_x_mm = 1, spacing_y_mm = 1;                   ///< PixelSpacing, columns then rows
  double thickness_mm = 0, tilt_deg = 0;                       ///< 0 where absent
  double slope = 1, intercept = 0;
  Vec3 Normal() const { return row_axis.cross(column_axis); }
};

/// Slices that share series, orientation, size and pixel spacing.
struct DicomSeries {
  std::string
      name;  ///< SeriesInstanceUID, with "#2" … where one UID holds unlike stacks, or "no-uid-1" …
  std::vector<DicomSlice> slices;  ///< by position along the normal, then by path
};

/// Reads the headers of all files below `folder` and groups the images. Other files are ignored
/// with one warning.
/// @throws InputError: no folder, no DICOM image, a header that breaks off, no position or spacing,
/// colour, multi-frame
std::vector<DicomSeries> ScanDicomFolder(const std::string& folder, Progress& progress);

/// Decoded and rescaled values of one slice, rows × columns, x fastest, HU.
/// @throws InputError when the voxel data break off or cannot be decoded
std::vector<float> ReadDicomPixels(const DicomSlice& slice);

}  // namespace kerf
