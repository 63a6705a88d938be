#pragma once

#include <vector>

#include "CaseIO/CaseFolder.h"
#include "Session/PlanningResection.h"

namespace kerf {

/// The planned resection of a case: its line as a curve of Slicer markups
/// (plan/resection.mrk.json), margin, direction and depth in the manifest's provenance. Patient
/// LPS, mm.

/// A plan without a line where the case has none. @throws InputError naming the file
ResectionPlan ReadResectionPlan(const CaseFolder& folder);
/// Takes the place of the plan that the case had. @throws InputError
void StageResectionPlan(const ResectionPlan& plan, CaseWriter* writer);

/// All other lines and curves that the case holds as plans (drawn in Slicer), as they are.
std::vector<Points> ReadOtherPlannedLines(const CaseFolder& folder);

}  // namespace kerf
