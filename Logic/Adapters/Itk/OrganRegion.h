#pragma once

#include "Adapters/Itk/Field.h"
#include "Adapters/Itk/Preset.h"

namespace kerf {

/// Parenchyma as seen around the seeds.
struct Tissue {
  double mean_hu = 0;
  double low_hu = 0, high_hu = 0;  ///< what counts as the same tissue
};

struct OrganRegion {
  Mask mask;  ///< on a crop of the CT's own grid (CropGrid), organ with all that it encloses
  Tissue tissue;
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

}  // namespace kerf
