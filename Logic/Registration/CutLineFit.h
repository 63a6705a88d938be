#pragma once

#include <vector>

#include "Registration/CutEvidence.h"

namespace kerf {

/// A line through the gap between the features of either side, in lateral coordinates: offset as a
/// low polynomial of the position along the tangent.
struct FittedLine {
  Vec2 origin = Vec2::Zero(), tangent = Vec2::UnitX(), normal = Vec2::UnitY();
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();  ///< o(t) = c0 + c1 t + c2 t²
  double begin_mm = 0.0, end_mm = 0.0;               ///< t of the outermost evidence
  double begin_tip_mm = 0.0,
         end_tip_mm = 0.0;  ///< reach of a tip beyond it: where the opening's square runs to 0

  Vec2 At(double t) const {
    return origin + t * tangent + (offset[0] + t * (offset[1] + t * offset[2])) * normal;
  }
};

/// @param group positions in `parting`, not empty
FittedLine FitCutLine(const std::vector<PartingEdge>& parting, const std::vector<Index>& group,
                      const FeatureTriangulation& triangulation, const DisplacementJumps& jumps);

}  // namespace kerf
