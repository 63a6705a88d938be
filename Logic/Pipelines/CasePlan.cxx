#include "Pipelines/CasePlan.h"

#include "Session/ResectionFiles.h"

namespace kerf {

PlannedCut ReadCasePlan(const std::string& case_folder, const SurfaceMesh& organ) {
  const CaseFolder opened = CaseFolder::Open(case_folder, false);
  PlannedCut out;
  out.lines = ReadOtherPlannedLines(opened);
  const ResectionPlan plan = ReadResectionPlan(opened);
  if (plan.line.rows() < 2) return out;
  out.lines.push_back(LineOnSurface(organ, plan.line));
  out.margin_mm = plan.margin_mm;
  const CutSurface sheet = ResectionSheet(organ, plan);
  out.sheet = {sheet.points, sheet.triangles};
  return out;
}

}  // namespace kerf
