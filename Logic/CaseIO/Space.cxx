#include "CaseIO/Space.h"

#include "Core/Errors.h"

namespace kerf {

const char* ToString(Space space) { return space == Space::RAS ? "RAS" : "LPS"; }

Space ParseSpace(const std::string& text, const std::string& file, const std::string& element) {
  if (text.empty() || text == "LPS" || text == "lps") return Space::LPS;
  if (text == "RAS" || text == "ras") return Space::RAS;
  throw InputError(file, element, "is \"" + text + "\", expected LPS or RAS");
}

Points FlipSpace(const Points& points) {
  Points out = points;
  out.leftCols<2>() *= -1.0;
  return out;
}

}  // namespace kerf
