#pragma once

#include <deque>
#include <vector>

#include "Registration/DisplacementJump.h"

namespace kerf {

/// Evidence for cuts, summed up over time. What a smooth but strongly varying strain leaves as a
/// jump grows in proportion to the organ's motion; each edge learns that proportion from its own
/// past, and only what comes in excess of it counts: a cut opens suddenly.
struct CutEvidence {
  FeatureTriangulation triangulation;
  Eigen::VectorXd learned;  ///< E, largest jump per mm of motion, up to `kMemory` frames ago
  std::deque<Eigen::VectorXd> recent;  ///< the same of the last frames, not learned yet
  std::vector<int> streak;             ///< E, frames in a row with excess
  Eigen::VectorXd last_mm;             ///< E, last jump that was seen
  std::vector<int> absent;             ///< F, frames in a row without this feature
  std::vector<int> back_for;           ///< F, frames since it came back from a long absence
  Eigen::VectorXd refused_mm;  ///< E, jump that a surgeon said is no cut; empty: nothing refused
};

/// An edge of the triangulation whose features part.
struct PartingEdge {
  Index edge = -1;
  double jump_mm = 0.0;
  double excess_mm = 0.0;
};

CutEvidence BeginEvidence(const Points& rest_camera, const std::vector<char>& usable);

/// What came back after it had been away for long (behind an instrument) may first be taken for
/// another place: for some frames its pairs bear no witness. @param usable one flag per feature
void DoubtReturned(const FeatureTriangulation& triangulation, const std::vector<char>& usable,
                   CutEvidence* evidence, DisplacementJumps* jumps);

/// One frame of evidence. @return edges that part and have done so for some frames, by edge number
std::vector<PartingEdge> UpdateEvidence(const DisplacementJumps& jumps, const Pixels& current,
                                        CutEvidence* evidence);

/// What is left when pairs whose parting was refused are taken out: they count again from twice the
/// refused jump and 2 mm more on. @return `parting` itself where nothing was refused
std::vector<PartingEdge> WithoutRefused(std::vector<PartingEdge> parting,
                                        const CutEvidence& evidence);

/// Parting edges that belong together: their middles are chained closer than twice the feature
/// spacing.
/// @return groups of positions in `parting`, largest total excess first
std::vector<std::vector<Index>> GroupParting(const std::vector<PartingEdge>& parting,
                                             const FeatureTriangulation& triangulation);

}  // namespace kerf
