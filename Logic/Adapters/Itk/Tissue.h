#pragma once

#include <string>
#include <vector>

#include "Adapters/Itk/Field.h"
#include "Adapters/Itk/Preset.h"

/// Private to this component: how bright an organ is.
namespace kerf {

/// Parenchyma as seen around the seeds.
struct Tissue {
  double mean_hu = 0;
  double low_hu = 0, high_hu = 0;  ///< what counts as the same tissue
};

/// Robust mean around the seeds, then over the tissue alike within 25 mm; the window is the
/// preset's least, three times the noise or the organ's distance from muscle, whichever is widest.
/// @param image denoised, working grid; @param seeds LPS mm
/// @throws InputError naming `source` when the seeds lie in nothing of the preset's kind
Tissue LearnTissue(const ScalarField& image, const OrganKnowledge& knowledge,
                   const std::vector<Vec3>& seeds, const std::string& source);

/// The brightness of what was found as a whole: the surroundings of a seed may be brighter or
/// darker than the organ is, and the window then leaves out much of it. Not where brightness is
/// followed.
/// @return whether it differs from what was known by more than 1 HU
bool LearnTissueAgain(const ScalarField& image, const Mask& found, const OrganKnowledge& knowledge,
                      Tissue* tissue);

/// Voxels inside the tissue's window.
Mask Alike(const ScalarField& image, const Tissue& tissue);

}  // namespace kerf
