#include "Adapters/Itk/Seeds.h"

#include <fmt/format.h>

#include <cctype>

#include "CaseIO/Markups.h"
#include "Core/Errors.h"

namespace kerf {
namespace {

/// "Organ-1" → "organ"
std::string KindWord(const std::string& label) {
  std::string word;
  for (const char c : label) {
    if (!std::isalpha(static_cast<unsigned char>(c))) break;
    word += static_cast<char>(std::tolower(c));
  }
  return word;
}

SeedKind ParseKind(const std::string& label, const std::string& path, const std::string& element) {
  const std::string word = KindWord(label);
  if (word == "organ") return SeedKind::Organ;
  if (word == "tumour" || word == "tumor") return SeedKind::Tumour;
  if (word == "internal") return SeedKind::Internal;
  if (word == "background") return SeedKind::Background;
  throw InputError(path, element + ".label",
                   "'" + label + "' is none of organ, tumour, internal, background");
}

}  // namespace

std::vector<Seed> ReadSeeds(const std::string& path) {
  std::vector<Seed> seeds;
  for (const MarkupList& list : ReadMarkups(path))
    for (const MarkupPoint& point : list.points)
      seeds.push_back({ParseKind(point.label, path, point.element), point.position_mm,
                       fmt::format("{} ({})", point.element, point.label)});
  if (seeds.empty()) throw InputError(path, "controlPoints", "no seed in the file");
  return seeds;
}

void CheckSeedsInside(const std::vector<Seed>& seeds, const GridGeometry& grid,
                      const std::string& file) {
  for (const Seed& seed : seeds) {
    const Vec3 index = grid.IndexFromWorld(seed.position_mm);
    for (int a = 0; a < 3; ++a)
      if (!(index[a] >= -0.5 && index[a] <= grid.size[a] - 0.5))
        throw InputError(
            file, seed.id,
            fmt::format("the seed at ({:.1f}, {:.1f}, {:.1f}) mm LPS lies outside the "
                        "volume",
                        seed.position_mm[0], seed.position_mm[1], seed.position_mm[2]));
  }
}

}  // namespace kerf
