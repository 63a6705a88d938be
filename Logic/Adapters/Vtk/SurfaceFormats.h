#pragma once

// Private: the formats that are read and written by hand, because VTK's readers crash on or
// silently accept broken files and its writers have no place for the space. All coordinates are
// those of the file; the caller converts.
#include <iosfwd>
#include <string>

#include "Core/SurfaceMesh.h"

namespace kerf {

struct RawSurface {
  SurfaceMesh surface;
  std::string space_tag;  ///< "LPS", "RAS", as found; empty where untagged
};

/// The whole file. @throws InputError when it is missing or cannot be read
std::string ReadWholeFile(const std::string& path);
/// The word after "SPACE=" (or "SPACE:") in a header or comment; empty where there is none.
std::string FindSpaceTag(const std::string& text);

RawSurface ReadStl(const std::string& path);
RawSurface ReadPly(const std::string& path);
RawSurface ReadObj(const std::string& path);
/// @param space_tag "LPS" or "RAS"
void WriteStl(const SurfaceMesh& surface, const std::string& space_tag, std::ostream& out);
void WritePly(const SurfaceMesh& surface, const std::string& space_tag, std::ostream& out);
void WriteObj(const SurfaceMesh& surface, const std::string& space_tag, std::ostream& out);
/// glTF 2.0 binary: metres, Y up (x = left, y = superior, z = anterior of the patient), one mesh.
/// @param surface LPS, mm
void WriteGlb(const SurfaceMesh& surface, std::ostream& out);

}  // namespace kerf
