#pragma once

#include <vector>

#include "Adapters/Itk/DicomHeaders.h"

namespace kerf {

/// Warns where headers tell of slices that are not in the folder and whose absence positions do not
/// show: before the first, behind the last, every second one. Nothing is refused: scanners number
/// and count in their own ways.
/// @param series the stack that is read, by position, without copies
/// @param all every stack of the folder: a localizer of the same series takes numbers, too
void WarnOfMissingSlices(const DicomSeries& series, const std::vector<DicomSeries>& all,
                         Progress& progress);

}  // namespace kerf
