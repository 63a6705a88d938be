#pragma once

#include <string>

namespace kerf {

/// What a DICOM header says about contrast.
struct ContrastTags {
  std::string description;       ///< SeriesDescription (0008,103e)
  std::string agent;             ///< ContrastBolusAgent (0018,0010)
  std::string injection_time;    ///< ContrastBolusStartTime (0018,1042), HHMMSS.F
  std::string acquisition_time;  ///< AcquisitionTime (0008,0032), HHMMSS.F
};

/// The phase of contrast in words: by the names that scanners' protocols give it (English, German,
/// French), else by whether an agent was given; with the seconds since the injection where both
/// times are there. Empty where nothing tells it.
std::string ContrastPhase(const ContrastTags& tags);

/// Laterality (0020,0060) or ImageLaterality (0020,0062) in words; empty where unpaired or absent.
std::string LateralityInWords(const std::string& code);

/// "Doe^Jane^^^" as "Doe, Jane".
std::string PersonName(const std::string& dicom);

}  // namespace kerf
