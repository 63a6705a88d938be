#pragma once

#include <string>
#include <vector>

#include "Core/Progress.h"

namespace kerf {

/// `kerf export`: meshes and label maps of a case or a results folder for other programs.
struct ExportRequest {
  std::string input;   ///< case folder or results folder
  std::string format;  ///< vtu, vtp, stl, ply, obj, glb, seg.nrrd
  bool ras = false;    ///< write RAS instead of LPS; both are tagged
  std::string output;  ///< folder, made where it does not exist
};

/// vtu: the tetra mesh (of results: as deformed and cut, with rest_position_mm and region). Surface
/// formats: organ, inner structures, tumour, and of results the separation surfaces. seg.nrrd: the
/// label map; of results, as deformed and cut: on the grid of the planned map and with its labels
/// where the case is known (in the results' folder `case`, or around a session), otherwise in 1 mm
/// voxels and by the tetrahedra's regions, without inner structures. glTF is metres and Y-up by
/// definition, whatever the space.
/// @return the files that were written
/// @throws UsageError on an unknown format; InputError naming file: neither case nor results,
/// nothing to export
std::vector<std::string> Export(const ExportRequest& request, Progress& progress);

}  // namespace kerf
