#pragma once

#include "Phantom/PhantomScene.h"

namespace kerf {

/// Material points on the surface that frame 0 sees, well spread, in organ axes.
struct PhantomFeatures {
  Points rest;              ///< N×3, organ axes, mm
  std::vector<int> region;  ///< between the sheets, per point
};

/// @param count wanted; the first ones of the list are as well spread as the whole
PhantomFeatures ChooseFeatures(const PhantomSetup& setup, const PhantomAnatomy& anatomy,
                               const PhantomView& first, int count);

/// Exact positions of the features at a frame.
struct PhantomTracks {
  Points world;   ///< LPS, mm
  Pixels pixels;  ///< raw (distorted)
  std::vector<std::uint8_t>
      visible;  ///< in the image, not hidden by the organ itself or an instrument
};
PhantomTracks TrackFeatures(const PhantomSetup& setup, const PhantomFeatures& features,
                            const PhantomView& view, int frame);

/// Landmarks that a surgeon would recognize: spread over the visible surface.
/// @return rows of ChooseFeatures' list
std::vector<Index> ChooseLandmarks(const PhantomFeatures& features, int count);

}  // namespace kerf
