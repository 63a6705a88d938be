#pragma once

#include <string>
#include <vector>

#include "Core/Types.h"

namespace kerf {

/// A control point of a Slicer markups list.
struct MarkupPoint {
  std::string label;
  Vec3 position_mm = Vec3::Zero();  ///< patient LPS
  std::string element = {};         ///< where it stood in the file, for messages
};

/// One list of Slicer markups (.mrk.json): landmarks, seeds, a resection line.
struct MarkupList {
  std::string type = "Fiducial";  ///< Fiducial, Line, Curve, ClosedCurve, …
  std::vector<MarkupPoint> points;
};

/// Reads Slicer markups. coordinateSystem LPS or RAS (older Slicer: 1 or 0); as the schema says,
/// absent means LPS. Points with positionStatus "undefined" are skipped.
/// @throws InputError naming the file and the control point
std::vector<MarkupList> ReadMarkups(const std::string& path);

/// Writes them, tagged LPS, as Slicer reads them. Atomic. @throws InputError
void WriteMarkups(const std::string& path, const std::vector<MarkupList>& lists);

}  // namespace kerf
