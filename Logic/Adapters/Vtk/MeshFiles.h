#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "CaseIO/Space.h"
#include "Core/SurfaceMesh.h"
#include "Core/TetMesh.h"

/// Mesh files of the field. Inside everything is LPS mm; files carry their space (FIELD (d)):
/// field-data array SPACE in .vtp/.vtu, `SPACE=LPS` in the header or a comment of .stl, .ply, .obj
/// and .vtk; untagged means LPS. RAS ↔ LPS turns by 180° about z, so that triangles keep their
/// orientation. Files appear whole or not at all.
namespace kerf {

/// A surface as a file holds it.
struct SurfaceFile {
  SurfaceMesh surface;                  ///< LPS, mm
  std::optional<Points> rest_position;  ///< point array rest_position_mm (.vtp), LPS
  Space space = Space::LPS;             ///< of the file, before conversion
};

/// .vtp .stl .ply .obj. Legacy .vtk is written but not read: VTK 9.1 crashes on truncated ones.
/// Polygons are triangulated. Corners at the same place are merged (.stl only, which has no
/// points). @throws InputError naming file and element: unknown extension, missing, truncated,
/// garbage, empty, indices out of range, coordinates that are no numbers
SurfaceFile ReadSurfaceFile(const std::string& path);
SurfaceMesh ReadSurface(const std::string& path);

/// .vtp .stl .ply .obj .vtk .glb by extension; .glb in metres and Y-up as glTF wants it, whatever
/// `space` says.
/// @param rest_position N×3, written where the format has a place for it (.vtp, .vtk); may be null
void WriteSurface(const SurfaceMesh& surface, const std::string& path, Space space = Space::LPS,
                  const Points* rest_position = nullptr);

/// A number per point that goes into the file under a name.
struct SurfaceArray {
  std::string name;
  std::variant<std::vector<std::int8_t>, std::vector<std::int32_t>, std::vector<float>> values;
};
/// .vtp with further point arrays. @throws UsageError for another extension; InputError when an
/// array has not one value per point or the file cannot be written
void WriteSurfaceWithArrays(const SurfaceMesh& surface, const std::string& path, Space space,
                            const std::vector<SurfaceArray>& arrays);

/// A whole-numbered point array of a .vtp, one value per point, in the order of the file's points.
/// @throws InputError also when it is missing or has not `expected` values
std::vector<Index> ReadPointArray(const std::string& path, const std::string& name, Index expected);

/// .vtu. @param positions current points, may be null
TetMesh ReadTetMesh(const std::string& path, Points* positions = nullptr);
/// .vtu .vtk with point array rest_position_mm and cell array region.
void WriteTetMesh(const TetMesh& mesh, const Points& positions, const std::string& path,
                  Space space = Space::LPS);

/// Is this an extension (without dot, lower case) that ReadSurface knows?
bool IsSurfaceExtension(const std::string& extension);
/// Extension without dot, lower case; "seg.nrrd" and "nii.gz" give their last part.
std::string FileExtension(const std::string& path);

}  // namespace kerf
