#pragma once

#include <cstdint>

#include "Core/Types.h"

namespace kerf {

/// What light meets at a surface point. Colours are linear RGB, 0..1.
struct SurfaceLook {
  Vec3 albedo = Vec3::Zero();
  double gloss = 0.5;        ///< strength of the wet highlight
  Vec3 bump = Vec3::Zero();  ///< added to the unit normal, organ axes
};

/// All looks depend on the rest position (organ axes, mm), so that they stick to the material.
SurfaceLook KidneyCapsule(const Vec3& rest, std::uint32_t seed);
SurfaceLook KidneySection(const Vec3& rest, std::uint32_t seed);
SurfaceLook SiliconeBand(const Vec3& rest, bool section, std::uint32_t seed);
/// What lies behind: fat with vessels (kidney) or a cloth (band); `p` on a plane, mm.
SurfaceLook FatBackground(const Vec3& p, std::uint32_t seed);
SurfaceLook ClothBackground(const Vec3& p, std::uint32_t seed);

}  // namespace kerf
