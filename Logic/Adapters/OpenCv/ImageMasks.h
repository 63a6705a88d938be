#pragma once

#include "Core/Frame.h"

namespace kerf {

/// Pixels of surgical instruments: grey (hardly any saturation) regions that enter from the image
/// border and are long or large. A colour rule, not a learnt one: coloured or fully covered tools
/// are missed, grey organs would not do.
/// @return 8-bit, 1 channel, 255 = instrument; all 0 where the frame has no image
Image InstrumentMask(const Frame& frame);

/// Specular highlights: nearly saturated in every colour, grown by two pixels.
/// @return 8-bit, 1 channel, 255 = highlight; all 0 where the frame has no image
Image SpecularMask(const Frame& frame);

}  // namespace kerf
