#pragma once

#include <limits>

#include "Geometry/SurfaceTree.h"
#include "Session/ModelView.h"

namespace kerf {

/// How far the faces of the cuts lie from the planned resection sheet, in mm of the organ at rest,
/// as it was planned: whatever the organ does meanwhile changes nothing. Weighted by area.
struct PlanDeviation {
  double mean_mm = std::numeric_limits<double>::quiet_NaN();
  double p95_mm = std::numeric_limits<double>::quiet_NaN();  ///< 95 % of the faces are nearer
  double max_mm = std::numeric_limits<double>::quiet_NaN();
};

/// All NaN where there is no face of a cut.
PlanDeviation MeasurePlanDeviation(const OrganView& organ, const SurfaceTree& sheet);

}  // namespace kerf
