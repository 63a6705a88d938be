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

constexpr std::size_t kHeader = 80, kRecord = 50;

/// Triangle soup → indexed surface: corners with the same coordinates become one point, in order of
/// first use.
class Indexer {
 public:
  Index Add(const std::array<float, 3>& p) {
    const auto [it, fresh] = index_.insert({p, static_cast<Index>(points_.size())});
    if (fresh) points_.push_back(p);
    return it->second;
  }
  Points Take() const {
    Points points(points_.size(), 3);
    for (std::size_t i = 0; i < points_.size(); ++i)
      points.row(i) << points_[i][0], points_[i][1], points_[i][2];
    return points;
  }

 private:
  std::map<std::array<float, 3>, Index> index_;
  std::vector<std::array<float, 3>> points_;
};

RawSurface FromSoup(const std::vector<std::array<float, 3>>& corners, const std::string& path) {
  Indexer indexer;
  std::vector<std::array<Index, 3>> kept;
  for (std::size_t t = 0; t < corners.size() / 3; ++t) {
    std::array<Index, 3> triangle;
    for (int k = 0; k < 3; ++k) {
      const auto& p = corners[3 * t + k];
      if (!std::isfinite(p[0]) || !std::isfinite(p[1]) || !std::isfinite(p[2]))
        throw InputError(path, "triangle " + std::to_string(t), "coordinate is not a number");
      triangle[k] = indexer.Add({p[0] + 0.0F, p[1] + 0.0F, p[2] + 0.0F});  // −0 becomes 0
    }
    // Slivers whose corners fall together in single precision carry no area.
    if (triangle[0] == triangle[1] || triangle[1] == triangle[2] || triangle[0] == triangle[2])
      continue;
    kept.push_back(triangle);
  }
  RawSurface out;
  out.surface.points = indexer.Take();
  out.surface.triangles.resize(kept.size(), 3);
  for (std::size_t t = 0; t < kept.size(); ++t)
    out.surface.triangles.row(t) << kept[t][0], kept[t][1], kept[t][2];
  return out;
}

RawSurface ReadAscii(const std::string& text, const std::string& path) {
  std::istringstream in(text);
  std::string line, word;
  std::getline(in, line);
  const std::string header = line;
  std::vector<std::array<float, 3>> corners;
  int number = 1;
  bool ended = false;
  while (std::getline(in, line)) {
    ++number;
    std::istringstream fields(line);
    if (!(fields >> word)) continue;
    if (word == "vertex") {
      std::array<float, 3> p;
      if (!(fields >> p[0] >> p[1] >> p[2]))
        throw InputError(path, "line " + std::to_string(number), "a vertex needs three numbers");
      corners.push_back(p);
    } else if (word == "endfacet" && corners.size() % 3 != 0) {
      throw InputError(path, "line " + std::to_string(number), "the facet has not three vertices");
    } else if (word == "endsolid") {
      ended = true;
    }
  }
  if (!ended || corners.size() % 3 != 0)
    throw InputError(path, "line " + std::to_string(number), "the file breaks off");
  RawSurface out = FromSoup(corners, path);
  out.space_tag = FindSpaceTag(header);
  return out;
}

}  // namespace

RawSurface ReadStl(const std::string& path) {
  const std::string bytes = ReadWholeFile(path);
  std::uint32_t count = 0;
  if (bytes.size() >= kHeader + 4) std::memcpy(&count, bytes.data() + kHeader, 4);
  // The size decides: binary headers may begin with "solid" too.
  const bool fits = bytes.size() >= kHeader + 4 && bytes.size() == kHeader + 4 + kRecord * count;
  if (!fits && bytes.compare(0, 5, "solid") == 0 && bytes.find("facet") != std::string::npos)
    return ReadAscii(bytes, path);
  if (bytes.size() < kHeader + 4) throw InputError(path, "header", "the file breaks off");
  if (bytes.size() < kHeader + 4 + std::size_t(kRecord) * count)
    throw InputError(path, "triangle " + std::to_string((bytes.size() - kHeader - 4) / kRecord),
                     "the file breaks off: " + std::to_string(count) + " triangles are announced");
  std::vector<std::array<float, 3>> corners(3 * std::size_t(count));
  for (std::size_t t = 0; t < count; ++t)
    std::memcpy(corners[3 * t].data(), bytes.data() + kHeader + 4 + kRecord * t + 12, 36);
  RawSurface out = FromSoup(corners, path);
  out.space_tag = FindSpaceTag(bytes.substr(0, kHeader));
  return out;
}

void WriteStl(const SurfaceMesh& surface, const std::string& space_tag, std::ostream& out) {
  std::string header = "Kerf surface, mm, SPACE=" + space_tag;
  header.resize(kHeader, ' ');
  out.write(header.data(), kHeader);
  const auto count = static_cast<std::uint32_t>(surface.triangles.rows());
  out.write(reinterpret_cast<const char*>(&count), 4);
  for (Index t = 0; t < surface.triangles.rows(); ++t) {
    std::array<Vec3, 3> corner;
    for (int k = 0; k < 3; ++k) corner[k] = surface.points.row(surface.triangles(t, k)).transpose();
    const Vec3 normal = (corner[1] - corner[0]).cross(corner[2] - corner[0]);
    const Vec3 unit = normal.norm() > 0 ? Vec3(normal.normalized()) : Vec3::Zero();
    std::array<float, 12> numbers;
    for (int d = 0; d < 3; ++d) {
      numbers[d] = static_cast<float>(unit[d]);
      for (int k = 0; k < 3; ++k) numbers[3 + 3 * k + d] = static_cast<float>(corner[k][d]);
    }
    const std::uint16_t attribute = 0;
    out.write(reinterpret_cast<const char*>(numbers.data()), sizeof numbers);
    out.write(reinterpret_cast<const char*>(&attribute), 2);
  }
}

}  // namespace kerf
