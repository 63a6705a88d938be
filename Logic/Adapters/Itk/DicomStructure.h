#pragma once

#include <string>

namespace kerf {

/// Walks the data elements of a DICOM file (little endian, explicit or implicit) without reading
/// their values. GDCM pads what is cut off, or ends the process on an assertion.
/// @return false for a file that is not DICOM at all
/// @throws InputError naming the element in which the file breaks off
bool CheckDicomStructure(const std::string& path);

}  // namespace kerf
