#pragma once

#include "Core/SurfaceMesh.h"
#include "Phantom/PhantomMotion.h"

namespace kerf {

/// The instruments in view at a frame: for the kidney a pair of scissors that follows the tip of
/// each cut, for bands the two grips. World coordinates, mm. Empty when nothing is in view.
struct PhantomTool {
  SurfaceMesh mesh;
  std::vector<std::uint8_t> is_metal;  ///< per point: bright metal, or dark coating
};

PhantomTool ToolAtFrame(const PhantomSetup& setup, const PhantomMotion& motion, double frame);

}  // namespace kerf
