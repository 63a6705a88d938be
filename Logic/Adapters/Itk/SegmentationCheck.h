#pragma once

#include "Adapters/Itk/InnerStructures.h"
#include "Adapters/Itk/OrganRegion.h"
#include "Adapters/Itk/Preset.h"
#include "Adapters/Itk/Segmentation.h"

namespace kerf {

/// The checks that a person would make, in numbers and sentences: fills all of `report` but
/// `left_out_ml` and adds to its warnings. Nothing is changed.
/// @param region, inner on one crop of the CT's own grid
void CheckSegmentation(const Volume& ct, const OrganKnowledge& knowledge, const OrganRegion& region,
                       const InnerStructures& inner, SegmentationReport* report);

/// Fills `left_out_ml`; says what was found apart from the organ and left out, and which seeds of a
/// person lie there.
/// @param found on the same crop as `kept`, its one component
void CheckLeftOut(const Mask& found, const Mask& kept, const OrganKnowledge& knowledge,
                  const std::vector<Seed>& seeds, SegmentationReport* report);

}  // namespace kerf
