#include "Session/AppliedCuts.h"

#include "Registration/CutLine.h"

namespace kerf {

bool IsApplied(const ModelCut& cut) { return cut.surface.triangles.rows() > 0 && !cut.held; }

std::vector<CutRecord> AppliedCuts(const RegistrationState& state, const SurfaceTree& uncut) {
  std::vector<CutRecord> applied;
  for (const ModelCut& cut : state.cuts)
    if (IsApplied(cut))
      applied.push_back({cut.detected_frame, LineOnSurface(cut.line, cut.view, uncut), cut.depth_mm,
                         cut.confidence});
  return applied;
}

}  // namespace kerf
