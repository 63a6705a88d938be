#include <array>
#include <cmath>
#include <cstdlib>
#include <ostream>
#include <sstream>
#include <vector>

#include "Adapters/Vtk/SurfaceFormats.h"
#include "Core/Errors.h"

namespace kerf {

RawSurface ReadObj(const std::string& path) {
  std::istringstream in(ReadWholeFile(path));
  std::vector<Vec3> points;
  std::vector<std::array<Index, 3>> triangles;
  RawSurface out;
  std::string line, word;
  int number = 0;
  while (std::getline(in, line)) {
    ++number;
    const auto fail = [&](const std::string& problem) {
      throw InputError(path, "line " + std::to_string(number), problem);
    };
    std::istringstream fields(line);
    if (!(fields >> word)) continue;
    if (word[0] == '#') {
      if (out.space_tag.empty()) out.space_tag = FindSpaceTag(line);
    } else if (word == "v") {
      Vec3 p;
      if (!(fields >> p[0] >> p[1] >> p[2]) || !p.allFinite()) fail("a vertex needs three numbers");
      points.push_back(p);
    } else if (word == "f") {
      std::vector<Index> corners;
      while (fields >> word) {
        char* end = nullptr;  // "7", "7/1", "7//3"; negative counts from the end
        const long v = std::strtol(word.c_str(), &end, 10);
        if (end == word.c_str() || (*end != '\0' && *end != '/'))
          fail("'" + word + "' is no index");
        const long index = v > 0 ? v - 1 : static_cast<long>(points.size()) + v;
        if (v == 0 || index < 0 || index >= static_cast<long>(points.size()))
          fail("refers to vertex " + std::to_string(v) + " of " + std::to_string(points.size()));
        corners.push_back(static_cast<Index>(index));
      }
      if (corners.size() < 3) fail("a face needs three vertices");
      for (std::size_t k = 2; k < corners.size(); ++k)
        triangles.push_back({corners[0], corners[k - 1], corners[k]});
    }
  }
  out.surface.points.resize(points.size(), 3);
  for (std::size_t i = 0; i < points.size(); ++i) out.surface.points.row(i) = points[i].transpose();
  out.surface.triangles.resize(triangles.size(), 3);
  for (std::size_t t = 0; t < triangles.size(); ++t)
    out.surface.triangles.row(t) << triangles[t][0], triangles[t][1], triangles[t][2];
  return out;
}

void WriteObj(const SurfaceMesh& surface, const std::string& space_tag, std::ostream& out) {
  out << "# Kerf surface, mm\n# SPACE=" << space_tag << "\n";
  char line[128];
  for (Index i = 0; i < surface.points.rows(); ++i) {
    std::snprintf(line, sizeof line, "v %.9g %.9g %.9g\n", surface.points(i, 0),
                  surface.points(i, 1), surface.points(i, 2));
    out << line;
  }
  for (Index t = 0; t < surface.triangles.rows(); ++t)
    out << "f " << surface.triangles(t, 0) + 1 << ' ' << surface.triangles(t, 1) + 1 << ' '
        << surface.triangles(t, 2) + 1 << '\n';
}

}  // namespace kerf
