#include "CaseIO/Markups.h"

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "CaseIO/AtomicFile.h"
#include "Core/Errors.h"

namespace kerf {
namespace {

using nlohmann::json;

std::string At(const char* name, std::size_t index) {
  return std::string(name) + "[" + std::to_string(index) + "]";
}

/// @return sign of x and y: −1 turns RAS into LPS
double SignOf(const json& list, const std::string& path, const std::string& element) {
  const json system = list.value("coordinateSystem", json("LPS"));
  if (system == "LPS" || system == 1) return 1;
  if (system == "RAS" || system == 0) return -1;
  throw InputError(path, element + ".coordinateSystem", "must be LPS or RAS");
}

MarkupPoint ReadPoint(const json& point, double sign, const std::string& path,
                      const std::string& element) {
  const json label = point.value("label", json());
  if (!label.is_string()) throw InputError(path, element + ".label", "missing");
  const json position = point.value("position", json());
  if (!position.is_array() || position.size() != 3)
    throw InputError(path, element + ".position", "must be three numbers");
  MarkupPoint read{label.get<std::string>(), Vec3::Zero(), element};
  for (int a = 0; a < 3; ++a) {
    if (!position[a].is_number() || !std::isfinite(position[a].get<double>()))
      throw InputError(path, element + ".position", "must be three numbers");
    read.position_mm[a] = position[a].get<double>() * (a < 2 ? sign : 1);
  }
  return read;
}

}  // namespace

std::vector<MarkupList> ReadMarkups(const std::string& path) {
  std::ifstream in(path);
  if (!in) throw InputError(path, "", "cannot be opened");
  json document;
  try {
    document = json::parse(in);
  } catch (const json::parse_error& error) {
    throw InputError(path, "byte " + std::to_string(error.byte), "is no JSON");
  }
  if (!document.is_object() || !document.contains("markups") || !document["markups"].is_array())
    throw InputError(path, "markups", "missing: is it a Slicer markups file (.mrk.json)?");
  std::vector<MarkupList> lists;
  for (std::size_t m = 0; m < document["markups"].size(); ++m) {
    const json& list = document["markups"][m];
    const std::string list_name = At("markups", m);
    if (!list.is_object()) throw InputError(path, list_name, "is no object");
    const double sign = SignOf(list, path, list_name);
    const json points = list.value("controlPoints", json::array());
    if (!points.is_array()) throw InputError(path, list_name + ".controlPoints", "is no list");
    MarkupList read;
    if (const json type = list.value("type", json()); type.is_string()) read.type = type;
    for (std::size_t p = 0; p < points.size(); ++p) {
      const std::string element = list_name + "." + At("controlPoints", p);
      if (!points[p].is_object()) throw InputError(path, element, "is no object");
      if (points[p].value("positionStatus", json("defined")) == "undefined") continue;
      read.points.push_back(ReadPoint(points[p], sign, path, element));
    }
    lists.push_back(std::move(read));
  }
  return lists;
}

void WriteMarkups(const std::string& path, const std::vector<MarkupList>& lists) {
  nlohmann::ordered_json document;
  document["@schema"] =
      "https://raw.githubusercontent.com/slicer/slicer/master/Modules/Loadable/Markups/Resources/"
      "Schema/markups-schema-v1.0.3.json#";
  document["markups"] = nlohmann::ordered_json::array();
  for (const MarkupList& list : lists) {
    nlohmann::ordered_json out{{"type", list.type},
                               {"coordinateSystem", "LPS"},
                               {"coordinateUnits", "mm"},
                               {"controlPoints", nlohmann::ordered_json::array()}};
    for (const MarkupPoint& point : list.points) {
      const Vec3& p = point.position_mm;
      out["controlPoints"].push_back({{"id", std::to_string(out["controlPoints"].size() + 1)},
                                      {"label", point.label},
                                      {"position", {p.x(), p.y(), p.z()}},
                                      {"positionStatus", "defined"}});
    }
    document["markups"].push_back(std::move(out));
  }
  AtomicFile file(path);
  file.Stream() << document.dump(1, ' ', false, nlohmann::json::error_handler_t::replace) << "\n";
  file.Commit();
}

}  // namespace kerf
