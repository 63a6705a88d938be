#pragma once

#include <string>

#include "Core/Types.h"

namespace kerf {

/// The two patient frames in use. Everything inside and everything written by default is LPS; RAS
/// has x and y flipped.
enum class Space { LPS, RAS };

const char* ToString(Space space);
/// "LPS" or "RAS" in either case; empty (untagged) means LPS. @throws InputError(file, element) on
/// anything else
Space ParseSpace(const std::string& text, const std::string& file, const std::string& element);

/// LPS ↔ RAS: the same flip of x and y in both directions.
inline Vec3 FlipSpace(const Vec3& p) { return {-p.x(), -p.y(), p.z()}; }
Points FlipSpace(const Points& points);

}  // namespace kerf
