#pragma once
// Private to Pipelines: what a run of a validation looks like at its end.

#include <string>
#include <utility>
#include <vector>

#include "Core/Frame.h"
#include "Pipelines/ValidatePipeline.h"

namespace kerf {

/// The overlay in the last frame and the organ there, coloured by the distance of each vertex to
/// the true surface, from the camera and from the side. What cannot be had is left out:
/// the overlay without a video, the organ without a mesh of that frame, all where nothing can be
/// drawn. Safe from several threads.
std::vector<std::pair<Image, std::string>> PicturesOf(const ValidationRun& run,
                                                      const std::string& study);

}  // namespace kerf
