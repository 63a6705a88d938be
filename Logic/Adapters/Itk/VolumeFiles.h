#pragma once

#include <map>
#include <string>
#include <vector>

#include "Core/Progress.h"
#include "Core/Volume.h"

namespace kerf {

struct VolumeReadOptions {
  /// SeriesInstanceUID (or the name that ListSeries gives) where a DICOM folder holds several.
  std::string series;
};

/// One image series of a DICOM folder, as ReadVolume would choose it.
struct SeriesInfo {
  std::string uid;          ///< SeriesInstanceUID; "no-uid-<n>" where the files carry none
  std::string description;  ///< SeriesDescription (0008,103e)
  std::string modality;
  int slices = 0;
  Vec3 spacing_mm = Vec3::Zero();  ///< third component from the slice positions
  // For the person who chooses; never written anywhere.
  std::string patient;     ///< name, ID and birth date, as far as they are there
  std::string laterality;  ///< "left", "right", "both" or empty
  std::string phase;       ///< of contrast, in words (DicomPhase.h); empty where nothing tells it
};

/// Reads a CT: a DICOM folder, NIfTI (.nii .nii.gz .hdr), NRRD (.nrrd .nhdr) or MetaImage (.mha
/// .mhd). World coordinates are patient LPS mm (NIfTI is converted); oblique directions and
/// left-handed grids are kept as they are. Values are rounded to int16 HU. Assumptions that were
/// made go to progress.Warn(); no patient name is kept.
/// @throws InputError naming file and element: missing, truncated, 2-D, 4-D, colour, spacing that
/// is no positive
///         number, sheared or contradictory axes, and for DICOM: two patients, several series and
///         none chosen, a missing slice, a gantry tilt, slices that do not belong together
/// @throws UsageError when options.series names no series of the folder
Volume ReadVolume(const std::string& path, const VolumeReadOptions& options, Progress& progress);
Volume ReadVolume(const std::string& path);

/// Makes ITK's object factories, which two threads must not do at the same moment: call it before
/// there are threads that read volumes.
void InitializeItk();

/// Series of a DICOM folder, sorted by name. @throws InputError when there is none
std::vector<SeriesInfo> ListSeries(const std::string& folder, Progress& progress);

/// Reads an integer image as labels 0..255; a .seg.nrrd as ReadSegmentation does. Same failures as
/// ReadVolume.
LabelMap ReadLabelMap(const std::string& path);

/// Format by extension: .nrrd .nii .nii.gz .mha; compressed. Written beside the target first, then
/// renamed.
/// @throws InputError when the file cannot be written or the extension is unknown
void WriteVolume(const std::string& path, const Volume& volume);
void WriteLabelMap(const std::string& path, const LabelMap& labels);

/// Slicer's .seg.nrrd: one layer, a segment for each of `names` (default: organ, tumour, internal)
/// with name, colour, label value, extent and terminology.
void WriteSegmentation(const std::string& path, const LabelMap& labels);

/// Slicer's .seg.nrrd: segments named organ, tumour (tumor), internal become labels 1, 2, 3; others
/// keep their label value (or take a free one from 4 on). Layers are merged in the file's order: a
/// later segment lies on top.
LabelMap ReadSegmentation(const std::string& path);

}  // namespace kerf
