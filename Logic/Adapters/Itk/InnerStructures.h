#pragma once

#include "Adapters/Itk/Field.h"
#include "Adapters/Itk/OrganRegion.h"
#include "Adapters/Itk/Preset.h"

namespace kerf {

struct InnerStructures {
  Mask tumour, internal;  ///< on the organ's grid, disjoint
  Mask apart = {};        ///< on the same grid: pieces that came off the organ and were left out
};

/// Finds what differs from the parenchyma inside the organ, and what grows out of it: darker
/// compact bodies are taken as tumour, brighter ones as inner structure (contrast-filled calyces,
/// vessels); where a person put seeds, those decide and their kind is looked for nowhere else.
/// Boundaries at half the contrast. `organ` is widened by bodies that grow out of it, bright ones
/// that lean on it are taken off it, and of what is left then the largest component is kept.
InnerStructures FindInnerStructures(const Volume& ct, const OrganKnowledge& knowledge,
                                    const Tissue& tissue, const ScalarField& drift_hu,
                                    const std::vector<Vec3>& tumour_seeds,
                                    const std::vector<Vec3>& internal_seeds, Mask* organ,
                                    Progress& progress);

}  // namespace kerf
