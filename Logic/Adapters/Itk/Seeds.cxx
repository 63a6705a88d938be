#include "Adapters/Itk/Seeds.h"

#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "Core/Errors.h"

namespace kerf {
namespace {

using nlohmann::json;

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
  std::ifstream in(path);
  if (!in) throw InputError(path, "", "cannot be opened");
  json document;
  try {
    document = json::parse(in);
  } catch (const json::parse_error& error) {
    throw InputError(path, fmt::format("byte {}", error.byte), "is no JSON");
  }
  if (!document.is_object() || !document.contains("markups") || !document["markups"].is_array())
    throw InputError(path, "markups", "missing: is it a Slicer markups file (.mrk.json)?");
  std::vector<Seed> seeds;
  const json& lists = document["markups"];
  for (std::size_t m = 0; m < lists.size(); ++m) {
    const std::string list_name = fmt::format("markups[{}]", m);
    if (!lists[m].is_object()) throw InputError(path, list_name, "is no object");
    const json system = lists[m].value("coordinateSystem", json("LPS"));
    // Older Slicer versions wrote numbers: 0 is RAS, 1 is LPS.
    const std::string space = system.is_number()   ? (system.get<int>() == 0 ? "RAS" : "LPS")
                              : system.is_string() ? system.get<std::string>()
                                                   : std::string();
    if (space != "LPS" && space != "RAS")
      throw InputError(path, list_name + ".coordinateSystem", "must be LPS or RAS");
    const json points = lists[m].value("controlPoints", json::array());
    if (!points.is_array()) throw InputError(path, list_name + ".controlPoints", "is no list");
    for (std::size_t p = 0; p < points.size(); ++p) {
      const std::string element = fmt::format("{}.controlPoints[{}]", list_name, p);
      const json& point = points[p];
      if (!point.is_object()) throw InputError(path, element, "is no object");
      if (point.value("positionStatus", json("defined")) == "undefined") continue;
      const json label = point.value("label", json());
      if (!label.is_string()) throw InputError(path, element + ".label", "missing");
      const json position = point.value("position", json());
      if (!position.is_array() || position.size() != 3)
        throw InputError(path, element + ".position", "must be three numbers");
      Seed seed;
      for (int a = 0; a < 3; ++a) {
        if (!position[a].is_number() || !std::isfinite(position[a].get<double>()))
          throw InputError(path, element + ".position", "must be three numbers");
        seed.position_mm[a] = position[a].get<double>() * (space == "RAS" && a < 2 ? -1 : 1);
      }
      seed.kind = ParseKind(label.get<std::string>(), path, element);
      seed.id = fmt::format("{} ({})", element, label.get<std::string>());
      seeds.push_back(seed);
    }
  }
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
