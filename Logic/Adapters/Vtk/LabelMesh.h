#pragma once

#include "Core/Volume.h"
#include "Meshing/TetMesher.h"

namespace kerf {

/// A label map meshed by vtkKerfLabelMapToTetraGrid, the filter that other people's pipelines have.
/// @throws what MeshLabelMap throws
TetMesh MeshByFilter(const LabelMap& labels, const MeshingOptions& options, Progress& progress,
                     MeshingReport* report);

}  // namespace kerf
