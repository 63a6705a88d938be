#pragma once

#include "Adapters/Rendering/OverlayScene.h"
#include "Adapters/Rendering/OverlayText.h"

namespace kerf {

/// Gate and reason (top left), time and figures (top right), legend (bottom left), notice (bottom
/// right).
/// @param scene what is drawn decides which legend entries appear
void DrawStatusPanel(const OverlayOptions& options, const OverlayScene& scene, TextPainter* text,
                     Image* bgr);

}  // namespace kerf
