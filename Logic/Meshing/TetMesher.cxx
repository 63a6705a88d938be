#include "Meshing/TetMesher.h"

#include "Meshing/DomainMesher.h"
#include "Meshing/LabelDomain.h"
#include "Meshing/LabelField.h"
#include "Meshing/SurfaceDomain.h"

namespace kerf {
namespace {

void RequireCount(const MeshingOptions& options) {
  if (options.tetrahedra < 100) throw UsageError("at least 100 tetrahedra must be asked for");
}

}  // namespace

TetMesh MeshLabelMap(const LabelMap& labels, const MeshingOptions& options, Progress& progress,
                     MeshingReport* report) {
  RequireCount(options);
  progress.Report(0.0, "smoothing labels");
  const std::vector<std::uint8_t> mask = OrganMask(labels, progress);
  const LabelField organ = SmoothMask(labels.grid, mask);
  std::vector<std::uint8_t> inside(mask.size());
  for (std::size_t v = 0; v < mask.size(); ++v)
    inside[v] = mask[v] && (*labels.voxels)[v] == static_cast<std::uint8_t>(Label::Tumour);
  const LabelField tumour = SmoothMask(labels.grid, inside);
  progress.ThrowIfCancelled();
  TetMesh mesh =
      MeshToCount(*MakeLabelDomain(organ, tumour), labels.source, options, progress, report);
  progress.Report(1.0, "meshed");
  return mesh;
}

TetMesh MeshClosedSurface(const SurfaceMesh& surface, const std::string& file,
                          const MeshingOptions& options, Progress& progress,
                          MeshingReport* report) {
  RequireCount(options);
  progress.Report(0.0, "checking the surface");
  RequireClosedSurface(surface, file);
  TetMesh mesh = MeshToCount(*MakeSurfaceDomain(surface), file, options, progress, report);
  progress.Report(1.0, "meshed");
  return mesh;
}

}  // namespace kerf
