#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <ostream>
#include <sstream>
#include <vector>

#include "Adapters/Vtk/SurfaceFormats.h"
#include "Core/Errors.h"

namespace kerf {
namespace {

struct Property {
  std::string name, type, count_type;  ///< count_type: of lists, otherwise empty
};
struct Element {
  std::string name;
  std::size_t count = 0;
  std::vector<Property> properties;
};
enum class Coding { Ascii, Little, Big };

/// Size and class of PLY's scalar types: i signed, u unsigned, f floating.
const std::map<std::string, std::pair<int, char>>& Types() {
  static const std::map<std::string, std::pair<int, char>> types{
      {"char", {1, 'i'}},  {"int8", {1, 'i'}},    {"uchar", {1, 'u'}},  {"uint8", {1, 'u'}},
      {"short", {2, 'i'}}, {"int16", {2, 'i'}},   {"ushort", {2, 'u'}}, {"uint16", {2, 'u'}},
      {"int", {4, 'i'}},   {"int32", {4, 'i'}},   {"uint", {4, 'u'}},   {"uint32", {4, 'u'}},
      {"float", {4, 'f'}}, {"float32", {4, 'f'}}, {"double", {8, 'f'}}, {"float64", {8, 'f'}}};
  return types;
}

class Body {
 public:
  Body(const std::string& bytes, std::size_t at, Coding coding, const std::string& path)
      : bytes_(bytes), at_(at), coding_(coding), path_(path) {
    if (coding == Coding::Ascii) text_.str(bytes.substr(at));
  }
  void At(const std::string& element, std::size_t i) {
    element_ = element;
    index_ = i;
  }
  [[noreturn]] void Fail(const std::string& problem) const {
    throw InputError(path_, element_ + " " + std::to_string(index_), problem);
  }
  double Read(const std::string& type) {
    if (coding_ == Coding::Ascii) {
      std::string word;
      if (!(text_ >> word)) Fail("the file breaks off");
      char* end = nullptr;
      const double value = std::strtod(word.c_str(), &end);
      if (end == word.c_str() || *end != '\0') Fail("'" + word + "' is no number");
      return value;
    }
    const auto [size, kind] = Types().at(type);
    if (at_ + size > bytes_.size()) Fail("the file breaks off");
    char raw[8];
    std::memcpy(raw, bytes_.data() + at_, size);
    at_ += size;
    if (coding_ == Coding::Big) std::reverse(raw, raw + size);
    if (kind == 'f') return size == 4 ? Cast<float>(raw) : Cast<double>(raw);
    if (size == 1) return kind == 'i' ? Cast<std::int8_t>(raw) : Cast<std::uint8_t>(raw);
    if (size == 2) return kind == 'i' ? Cast<std::int16_t>(raw) : Cast<std::uint16_t>(raw);
    return kind == 'i' ? Cast<std::int32_t>(raw) : Cast<std::uint32_t>(raw);
  }

 private:
  template <typename T>
  static double Cast(const char* raw) {
    T value;
    std::memcpy(&value, raw, sizeof value);
    return static_cast<double>(value);
  }
  const std::string& bytes_;
  std::size_t at_;
  Coding coding_;
  std::string path_, element_ = "header";
  std::size_t index_ = 0;
  std::istringstream text_;
};

}  // namespace

RawSurface ReadPly(const std::string& path) {
  const std::string bytes = ReadWholeFile(path);
  RawSurface out;
  std::vector<Element> elements;
  Coding coding = Coding::Ascii;
  bool has_format = false, ended = false;
  std::size_t at = 0;
  for (int number = 1; at < bytes.size() && !ended; ++number) {
    const std::size_t end = bytes.find('\n', at);
    if (end == std::string::npos) break;
    std::string line = bytes.substr(at, end - at);
    at = end + 1;
    const auto fail = [&](const std::string& problem) {
      throw InputError(path, "line " + std::to_string(number), problem);
    };
    std::istringstream fields(line);
    std::string word;
    fields >> word;
    if (number == 1) {
      if (word != "ply") fail("is no PLY file");
    } else if (word == "format") {
      fields >> word;
      has_format = true;
      if (word == "binary_little_endian")
        coding = Coding::Little;
      else if (word == "binary_big_endian")
        coding = Coding::Big;
      else if (word != "ascii")
        fail("unknown format '" + word + "'");
    } else if (word == "comment" || word == "obj_info") {
      if (out.space_tag.empty()) out.space_tag = FindSpaceTag(line);
    } else if (word == "element") {
      Element element;
      if (!(fields >> element.name >> element.count)) fail("an element needs a name and a count");
      // Every element takes at least a byte: larger counts are garbage and would exhaust memory.
      if (element.count > bytes.size()) fail("announces more elements than the file can hold");
      elements.push_back(element);
    } else if (word == "property") {
      Property property;
      fields >> property.type;
      if (property.type == "list") fields >> property.count_type >> property.type;
      if (!(fields >> property.name) || !Types().count(property.type) ||
          (!property.count_type.empty() && !Types().count(property.count_type)) || elements.empty())
        fail("cannot be understood");
      elements.back().properties.push_back(property);
    } else if (word == "end_header") {
      ended = true;
    }
  }
  if (!ended || !has_format) throw InputError(path, "header", "is no complete PLY header");

  Body body(bytes, at, coding, path);
  std::vector<std::array<Index, 3>> triangles;
  for (const Element& element : elements) {
    if (element.name == "vertex") out.surface.points.resize(element.count, 3);
    std::array<int, 3> column{-1, -1, -1};
    for (std::size_t p = 0; p < element.properties.size(); ++p)
      for (int d = 0; d < 3; ++d)
        if (element.properties[p].name == std::string(1, "xyz"[d])) column[d] = static_cast<int>(p);
    if (element.name == "vertex" && *std::min_element(column.begin(), column.end()) < 0)
      throw InputError(path, "header", "vertices have no x, y, z");
    for (std::size_t i = 0; i < element.count; ++i) {
      body.At(element.name, i);
      for (std::size_t p = 0; p < element.properties.size(); ++p) {
        const Property& property = element.properties[p];
        if (property.count_type.empty()) {
          const double value = body.Read(property.type);
          if (element.name != "vertex") continue;
          for (int d = 0; d < 3; ++d)
            if (column[d] == static_cast<int>(p)) out.surface.points(i, d) = value;
          continue;
        }
        const double count = body.Read(property.count_type);
        if (!(count >= 0 && count < 1e6)) body.Fail("has an impossible list length");
        std::vector<double> list(static_cast<std::size_t>(count));
        for (double& v : list) v = body.Read(property.type);
        if (element.name != "face" || property.name.rfind("vertex_ind", 0) != 0) continue;
        if (list.size() < 3) body.Fail("has fewer than three corners");
        for (double v : list)
          if (!(v >= 0 && v < out.surface.points.rows()))
            body.Fail("refers to vertex " + std::to_string(static_cast<long>(v)) + " of " +
                      std::to_string(out.surface.points.rows()));
        for (std::size_t k = 2; k < list.size(); ++k)
          triangles.push_back({static_cast<Index>(list[0]), static_cast<Index>(list[k - 1]),
                               static_cast<Index>(list[k])});
      }
    }
  }
  out.surface.triangles.resize(triangles.size(), 3);
  for (std::size_t t = 0; t < triangles.size(); ++t)
    out.surface.triangles.row(t) << triangles[t][0], triangles[t][1], triangles[t][2];
  return out;
}

void WritePly(const SurfaceMesh& surface, const std::string& space_tag, std::ostream& out) {
  out << "ply\nformat binary_little_endian 1.0\ncomment Kerf surface, mm\ncomment SPACE="
      << space_tag << "\nelement vertex " << surface.points.rows()
      << "\nproperty double x\nproperty double y\nproperty double z\nelement face "
      << surface.triangles.rows() << "\nproperty list uchar int vertex_indices\nend_header\n";
  out.write(reinterpret_cast<const char*>(surface.points.data()),
            static_cast<std::streamsize>(sizeof(double) * surface.points.size()));
  for (Index t = 0; t < surface.triangles.rows(); ++t) {
    const char three = 3;
    out.write(&three, 1);
    for (int k = 0; k < 3; ++k) {
      const std::int32_t v = surface.triangles(t, k);
      out.write(reinterpret_cast<const char*>(&v), 4);
    }
  }
}

}  // namespace kerf
