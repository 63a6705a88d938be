#pragma once

#include <string>

#include "Core/SurfaceMesh.h"
#include "Session/SnapshotMaker.h"

namespace kerf {

/// The planned resection of a case for the operating room: its line on the organ and its sheet, and
/// all other lines that were drawn into the case. At rest, patient LPS, mm.
/// @param organ the case's rest surface; @throws InputError naming the file
PlannedCut ReadCasePlan(const std::string& case_folder, const SurfaceMesh& organ);

}  // namespace kerf
