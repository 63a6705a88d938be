#pragma once

#include <vector>

#include "Adapters/Itk/Field.h"
#include "Adapters/Itk/OrganRegion.h"

/// Private to this component.
namespace kerf {

/// How much brighter than tissue.mean_hu the organ is, place by place: beam hardening and arms
/// beside the body darken parts of it by more than any window allows. Local mean over what is alike
/// and connected to a seed, followed outwards in a few rounds; interior voxels only, so that rims
/// and thin neighbours do not count.
/// @param image denoised, working grid @param seeds LPS mm
/// @return HU on the image's grid; 0 far from the organ
ScalarField BrightnessDrift_hu(const ScalarField& image, const Tissue& tissue,
                               const std::vector<Vec3>& seeds, Progress& progress);

}  // namespace kerf
