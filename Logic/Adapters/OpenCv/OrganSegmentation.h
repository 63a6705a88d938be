#pragma once

#include "Core/Frame.h"

namespace kerf {

/// Silhouette of the organ in one frame, from colour: histograms of what lies clearly inside and
/// clearly outside the model's projection are learnt from this very frame, then each pixel goes to
/// the likelier side, smoothed and drawn towards the projection. Background that is seen through an
/// opened cut is not organ; what instruments hide is marked as hidden. Where tissue around the
/// organ has the organ's colours, the answer is hardly better than the projection.
/// @param model_mask 8-bit, 1 channel, the frame's size: projection of the model as it is now (some
/// 20 px off is fine)
/// @return 8-bit, 1 channel, values of OrganSegmenter; equal to `model_mask` where nothing can be
/// learnt (no image, mask too small)
/// @throws InputError when the sizes differ
Image OrganMask(const Frame& frame, const Image& model_mask);

}  // namespace kerf
