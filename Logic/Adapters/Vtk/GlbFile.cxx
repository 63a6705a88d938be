#include <nlohmann/json.hpp>
#include <ostream>
#include <vector>

#include "Adapters/Vtk/SurfaceFormats.h"

namespace kerf {
namespace {

void WriteU32(std::uint32_t value, std::ostream& out) {
  out.write(reinterpret_cast<const char*>(&value), 4);
}

}  // namespace

void WriteGlb(const SurfaceMesh& surface, std::ostream& out) {
  std::vector<float> positions;
  std::array<float, 3> low{1e30F, 1e30F, 1e30F}, high{-1e30F, -1e30F, -1e30F};
  for (Index i = 0; i < surface.points.rows(); ++i) {
    // A rotation: triangles keep their orientation.
    const std::array<double, 3> p{surface.points(i, 0), surface.points(i, 2),
                                  -surface.points(i, 1)};
    for (int d = 0; d < 3; ++d) {
      const auto metres = static_cast<float>(0.001 * p[d]);
      positions.push_back(metres);
      low[d] = std::min(low[d], metres);
      high[d] = std::max(high[d], metres);
    }
  }
  std::vector<std::uint32_t> indices(surface.triangles.size());
  for (std::size_t i = 0; i < indices.size(); ++i)
    indices[i] = static_cast<std::uint32_t>(surface.triangles.data()[i]);
  const std::size_t position_bytes = 4 * positions.size(), index_bytes = 4 * indices.size();

  nlohmann::ordered_json scene;
  scene["asset"] = {{"version", "2.0"}, {"generator", "Kerf"}};
  scene["asset"]["extras"]["SPACE"] = "metres, x left, y superior, z anterior (from LPS)";
  scene["scene"] = 0;
  scene["scenes"] = {{{"nodes", {0}}}};
  scene["nodes"] = {{{"mesh", 0}}};
  scene["materials"] = nlohmann::ordered_json::array();
  scene["materials"].push_back({{"doubleSided", true}});
  scene["meshes"] = nlohmann::ordered_json::array();
  scene["meshes"].push_back(
      {{"primitives",
        {{{"attributes", {{"POSITION", 0}}}, {"indices", 1}, {"material", 0}, {"mode", 4}}}}});
  scene["buffers"] = nlohmann::ordered_json::array();
  scene["buffers"].push_back({{"byteLength", position_bytes + index_bytes}});
  scene["bufferViews"] = nlohmann::ordered_json::array();
  scene["bufferViews"].push_back(
      {{"buffer", 0}, {"byteOffset", 0}, {"byteLength", position_bytes}, {"target", 34962}});
  scene["bufferViews"].push_back({{"buffer", 0},
                                  {"byteOffset", position_bytes},
                                  {"byteLength", index_bytes},
                                  {"target", 34963}});
  scene["accessors"] = nlohmann::ordered_json::array();
  scene["accessors"].push_back({{"bufferView", 0},
                                {"componentType", 5126},
                                {"count", surface.points.rows()},
                                {"type", "VEC3"},
                                {"min", low},
                                {"max", high}});
  scene["accessors"].push_back(
      {{"bufferView", 1}, {"componentType", 5125}, {"count", indices.size()}, {"type", "SCALAR"}});
  std::string text = scene.dump();
  text.resize((text.size() + 3) / 4 * 4, ' ');

  const std::size_t binary = position_bytes + index_bytes;
  WriteU32(0x46546C67, out);  // "glTF"
  WriteU32(2, out);
  WriteU32(static_cast<std::uint32_t>(12 + 8 + text.size() + 8 + binary), out);
  WriteU32(static_cast<std::uint32_t>(text.size()), out);
  WriteU32(0x4E4F534A, out);  // "JSON"
  out.write(text.data(), static_cast<std::streamsize>(text.size()));
  WriteU32(static_cast<std::uint32_t>(binary), out);
  WriteU32(0x004E4942, out);  // "BIN"
  out.write(reinterpret_cast<const char*>(positions.data()),
            static_cast<std::streamsize>(position_bytes));
  out.write(reinterpret_cast<const char*>(indices.data()),
            static_cast<std::streamsize>(index_bytes));
}

}  // namespace kerf
