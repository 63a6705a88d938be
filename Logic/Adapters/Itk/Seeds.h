#pragma once

#include <string>
#include <vector>

#include "Core/Volume.h"

namespace kerf {

enum class SeedKind { Background, Organ, Tumour, Internal };

/// A point that a person put into the CT.
struct Seed {
  SeedKind kind = SeedKind::Organ;
  Vec3 position_mm = Vec3::Zero();  ///< patient LPS
  std::string id;                   ///< as in the file, for messages
};

/// Reads Slicer markups (.mrk.json): control points whose `label` is organ, tumour (tumor),
/// internal or background (case does not matter; a number or text after `-`, `_` or a blank is
/// ignored: "organ-1"). coordinateSystem LPS or RAS; as the schema says, absent means LPS. Points
/// with positionStatus "undefined" are skipped.
/// @throws InputError naming the file and the control point
std::vector<Seed> ReadSeeds(const std::string& path);

/// @throws InputError naming `file` and the seed that lies outside the volume
void CheckSeedsInside(const std::vector<Seed>& seeds, const GridGeometry& grid,
                      const std::string& file);

}  // namespace kerf
