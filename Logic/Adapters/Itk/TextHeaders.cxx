#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <regex>
#include <sstream>
#include <vector>

#include "Adapters/Itk/RawHeader.h"
#include "Core/Errors.h"
#include "Core/Types.h"

namespace kerf {
namespace {

std::string Trimmed(const std::string& text) {
  const auto first = text.find_first_not_of(" \t\r");
  if (first == std::string::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

std::string Lower(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(c));
  return text;
}

/// `key<separator>value` lines up to the line where voxels begin.
std::map<std::string, std::string> ReadLines(std::ifstream& in, char separator,
                                             const std::string& last_key) {
  std::map<std::string, std::string> fields;
  std::string line;
  while (std::getline(in, line) && line.size() < 100000) {
    if (Trimmed(line).empty()) break;
    const auto at = line.find(separator);
    if (line[0] == '#' || at == std::string::npos) continue;
    if (separator == ':' && at + 1 < line.size() && line[at + 1] == '=')
      continue;  // NRRD key/value
    const std::string key = Lower(Trimmed(line.substr(0, at)));
    fields[key] = Trimmed(line.substr(at + 1));
    if (key == last_key) break;
  }
  return fields;
}

std::vector<double> Numbers(const std::string& text) {
  std::vector<double> values;
  std::istringstream in(text);
  for (std::string word; in >> word;) {
    char* rest = nullptr;
    const double value = std::strtod(word.c_str(), &rest);
    values.push_back(*rest ? std::nan("") : value);
  }
  return values;
}

void CheckSpacing(const std::string& path, const std::string& element, double spacing) {
  if (!std::isfinite(spacing)) throw InputError(path, element, "the spacing is not a number");
  if (spacing <= 0)
    throw InputError(path, element, fmt::format("the spacing {} must be positive", spacing));
}

}  // namespace

void CheckNrrdHeader(const std::string& path, bool allow_layers, Progress& progress) {
  std::ifstream in(path, std::ios::binary);
  std::string magic;
  if (!std::getline(in, magic)) throw InputError(path, "header", "truncated or unreadable");
  if (magic.rfind("NRRD000", 0) != 0) throw InputError(path, "line 1", "not an NRRD file");
  const auto fields = ReadLines(in, ':', "");
  const auto field = [&](const std::string& key) {
    const auto it = fields.find(key);
    return it == fields.end() ? std::string() : it->second;
  };
  const int dimension = std::atoi(field("dimension").c_str());
  std::vector<double> sizes = Numbers(field("sizes"));
  if (dimension <= 0 || int(sizes.size()) != dimension)
    throw InputError(path, "sizes", "does not give one number for each dimension");
  const bool layered = allow_layers && dimension == 4 && field("kinds").rfind("list", 0) == 0;
  if (!layered) {
    const std::string kinds = Lower(field("kinds"));
    if (kinds.find("rgb") != std::string::npos || kinds.find("color") != std::string::npos ||
        kinds.find("vector") != std::string::npos)
      throw InputError(path, "kinds", "a colour or vector image is no CT");
    if (dimension != 3)
      throw InputError(path, "dimension", fmt::format("a {}-D image is no volume", dimension));
  }
  for (std::size_t a = layered ? 1 : 0; a < sizes.size(); ++a)
    if (!(sizes[a] >= 2))
      throw InputError(path, "sizes", fmt::format("{} voxels along one axis: no volume", sizes[a]));

  const std::string directions = field("space directions");
  if (!directions.empty()) {
    static const std::regex vector_pattern(R"(\(([^)]*)\)|none)");
    std::vector<Vec3> axes;
    for (std::sregex_iterator it(directions.begin(), directions.end(), vector_pattern), end;
         it != end; ++it) {
      if (it->str() == "none") continue;
      std::string inside = (*it)[1];
      std::replace(inside.begin(), inside.end(), ',', ' ');
      const auto v = Numbers(inside);
      if (v.size() != 3) throw InputError(path, "space directions", "not three components");
      axes.emplace_back(v[0], v[1], v[2]);
    }
    if (axes.size() != 3) throw InputError(path, "space directions", "not three axes");
    Mat3 unit;
    for (int a = 0; a < 3; ++a) {
      CheckSpacing(path, fmt::format("space directions, axis {}", a + 1), axes[a].norm());
      unit.col(a) = axes[a].normalized();
    }
    if ((unit.transpose() * unit - Mat3::Identity()).cwiseAbs().maxCoeff() > 1e-2)
      throw InputError(path, "space directions",
                       "axes are sheared; resample to an orthogonal grid first");
  } else {
    const auto spacings = Numbers(field("spacings"));
    if (spacings.empty())
      throw InputError(path, "spacings", "neither spacings nor space directions");
    for (const double s : spacings) CheckSpacing(path, "spacings", s);
  }
  if (field("space").empty() && field("space dimension").empty())
    progress.Warn(path + ": no anatomical space is given; the axes are assumed to be LPS");
}

void CheckMetaImageHeader(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) throw InputError(path, "", "cannot be opened");
  const auto fields = ReadLines(in, '=', "elementdatafile");
  const auto field = [&](const std::string& key) {
    const auto it = fields.find(key);
    return it == fields.end() ? std::string() : it->second;
  };
  if (field("ndims").empty()) throw InputError(path, "NDims", "not a MetaImage file");
  const int dimension = std::atoi(field("ndims").c_str());
  if (dimension != 3)
    throw InputError(path, "NDims", fmt::format("a {}-D image is no volume", dimension));
  const auto sizes = Numbers(field("dimsize"));
  if (sizes.size() != 3) throw InputError(path, "DimSize", "not three numbers");
  for (const double s : sizes)
    if (!(s >= 2)) throw InputError(path, "DimSize", fmt::format("{} voxels along one axis", s));
  if (!field("elementnumberofchannels").empty() &&
      std::atoi(field("elementnumberofchannels").c_str()) != 1)
    throw InputError(path, "ElementNumberOfChannels", "a colour or vector image is no CT");
  const std::string key = field("elementspacing").empty() ? "ElementSize" : "ElementSpacing";
  const auto spacing = Numbers(field(Lower(key)));
  if (spacing.size() != 3) throw InputError(path, "ElementSpacing", "missing");
  for (const double s : spacing) CheckSpacing(path, key, s);

  // ITK takes what is there and leaves the rest undefined.
  static const std::map<std::string, int> kBytes = {
      {"met_char", 1}, {"met_uchar", 1}, {"met_short", 2},    {"met_ushort", 2},
      {"met_int", 4},  {"met_uint", 4},  {"met_float", 4},    {"met_double", 8},
      {"met_long", 8}, {"met_ulong", 8}, {"met_long_long", 8}};
  const auto type = kBytes.find(Lower(field("elementtype")));
  if (type == kBytes.end())
    throw InputError(path, "ElementType", "'" + field("elementtype") + "' is not known");
  const bool compressed = Lower(field("compresseddata")) == "true";
  const std::string stored = field("compresseddatasize");
  if (Lower(field("elementdatafile")) != "local" || (compressed && stored.empty())) return;
  const double needed = compressed ? std::strtod(stored.c_str(), nullptr)
                                   : sizes[0] * sizes[1] * sizes[2] * type->second;
  const auto begin = in.tellg();
  in.seekg(0, std::ios::end);
  const double have = double(in.tellg() - begin);
  if (begin < 0 || have < needed)
    throw InputError(path, "voxel data",
                     fmt::format("truncated: {:.0f} of {:.0f} bytes", have, needed));
}

}  // namespace kerf
