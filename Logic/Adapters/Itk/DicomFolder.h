#pragma once

#include <string>
#include <vector>

#include "Adapters/Itk/VolumeFiles.h"

namespace kerf {

/// DICOM folder → volume; see ReadVolume.
Volume ReadDicomFolder(const std::string& folder, const std::string& series, Progress& progress);

}  // namespace kerf
