#pragma once

#include "Adapters/Itk/Field.h"
#include "Adapters/Itk/Preset.h"
#include "Adapters/Itk/Tissue.h"

namespace kerf {

struct OrganRegion {
  Mask mask;  ///< on a crop of the CT's own grid (CropGrid), organ with all that it encloses
  Tissue tissue;
  Mask alike;            ///< what has the tissue's brightness all around, on the working grid
  ScalarField drift_hu;  ///< BrightnessDrift_hu on the working grid
};

/// Organ from seeds: coarse grid → same tissue → parts divided at necks → random walker against
/// what is certainly something else → the same once more in a band on the CT's own voxels →
/// geodesic active contour.
/// @param organ, background points in patient LPS, at least one of the organ
/// @throws InputError when the seed lies in nothing of the preset's kind
OrganRegion FindOrgan(const Volume& ct, const OrganKnowledge& knowledge,
                      const std::vector<Vec3>& organ, const std::vector<Vec3>& background,
                      const std::string& seeds_source, Progress& progress);

/// Share of an organ's surroundings, 3 to 5 mm outside its surface, that have the organ's own
/// brightness: no edge ends the organ there. Either it goes on, or it touches something as bright.
/// @param alike OrganRegion::alike; @return 0..1
double OpenShare(const Mask& organ, const Mask& alike);

}  // namespace kerf
