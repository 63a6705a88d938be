#include <filesystem>
#include <optional>

#include "Adapters/Itk/VolumeFiles.h"
#include "Adapters/Vtk/LabelSurface.h"
#include "Adapters/Vtk/MeshFiles.h"
#include "CaseIO/TransformFile.h"
#include "Core/Embedding.h"
#include "Core/Errors.h"
#include "Geometry/SurfaceTree.h"
#include "Meshing/LabelField.h"
#include "Pipelines/EvaluatePipeline.h"

namespace fs = std::filesystem;

namespace kerf {
namespace {

constexpr int kSamples = 3000;
constexpr Index kReferencePoints = 40000;

using Mask = std::vector<std::uint8_t>;

/// 1 where the voxel has one of these labels.
Mask MaskOf(const LabelMap& labels, const std::vector<Label>& wanted) {
  Mask mask(labels.voxels->size(), 0);
  for (std::size_t i = 0; i < mask.size(); ++i)
    for (Label label : wanted)
      if ((*labels.voxels)[i] == static_cast<std::uint8_t>(label)) mask[i] = 1;
  return mask;
}

/// Boundary of a mask, below voxel size, in the frame of the case; empty where the mask is.
SurfaceMesh MaskSurface(const GridGeometry& grid, const Mask& mask, const Eigen::Affine3d& move,
                        const std::string& file) {
  const LabelField field = SmoothMask(grid, mask);
  if (field.Empty()) return {};
  SurfaceMesh surface = SurfaceOfField(field, file, kReferencePoints);
  for (Index i = 0; i < surface.points.rows(); ++i)
    surface.points.row(i) = (move * Vec3(surface.points.row(i).transpose())).transpose();
  return surface;
}

double DiceOf(const Mask& a, const Mask& b) {
  std::size_t both = 0, sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    both += a[i] && b[i];
    sum += std::size_t(a[i] != 0) + std::size_t(b[i] != 0);
  }
  return sum == 0 ? 1.0 : 2.0 * static_cast<double>(both) / static_cast<double>(sum);
}

/// Voxels whose centre lies in a tetrahedron, of one region or of all. @param positions in the
/// frame of the grid
Mask TetMask(const GridGeometry& grid, const TetMesh& mesh, const Points& positions,
             std::optional<Label> only) {
  Mask mask(grid.VoxelCount(), 0);
  for (Index t = 0; t < mesh.TetCount(); ++t) {
    if (only && mesh.region[t] != static_cast<std::uint8_t>(*only)) continue;
    Vec3 corner[4], low = Vec3::Constant(1e300), high = -low;
    for (int k = 0; k < 4; ++k) {
      corner[k] = grid.IndexFromWorld(positions.row(mesh.tets(t, k)).transpose());
      low = low.cwiseMin(corner[k]);
      high = high.cwiseMax(corner[k]);
    }
    const Eigen::Vector3i first = low.cwiseMax(0.0).array().ceil().cast<int>();
    const Eigen::Vector3i last =
        high.cwiseMin((grid.size.array() - 1).cast<double>().matrix()).array().floor().cast<int>();
    for (int k = first[2]; k <= last[2]; ++k)
      for (int j = first[1]; j <= last[1]; ++j)
        for (int i = first[0]; i <= last[0]; ++i)
          if (BarycentricWeights(Vec3(i, j, k), corner[0], corner[1], corner[2], corner[3])
                  .minCoeff() >= -1e-9)
            mask[grid.Offset(i, j, k)] = 1;
  }
  return mask;
}

/// Voxels whose centre lies inside a closed surface. @param move from the grid to the frame of the
/// surface
Mask SurfaceMask(const GridGeometry& grid, const Eigen::Affine3d& move, const SurfaceMesh& closed,
                 Progress& progress) {
  const SurfaceTree tree(closed);
  const Vec3 low = closed.points.colwise().minCoeff().transpose();
  const Vec3 high = closed.points.colwise().maxCoeff().transpose();
  Mask mask(grid.VoxelCount(), 0);
  for (int k = 0; k < grid.size[2]; ++k) {
    progress.ThrowIfCancelled();
    for (int j = 0; j < grid.size[1]; ++j)
      for (int i = 0; i < grid.size[0]; ++i) {
        const Vec3 p = move * grid.WorldFromIndex(Vec3(i, j, k));
        mask[grid.Offset(i, j, k)] =
            (p.array() >= low.array()).all() && (p.array() <= high.array()).all() && tree.Inside(p);
      }
  }
  return mask;
}

}  // namespace

ReferenceScores EvaluateAgainstLabels(const std::string& results, const std::string& labels_file,
                                      const std::string& transform_file, Progress& progress) {
  progress.Report(0.0, "reading the second CT's labels");
  const LabelMap labels = ReadLabelMap(labels_file);
  const Eigen::Affine3d move =
      transform_file.empty() ? Eigen::Affine3d::Identity() : ReadTransformFile(transform_file);
  const auto in = [&](const char* name) { return (fs::path(results) / name).string(); };
  Points positions;
  const TetMesh mesh = ReadTetMesh(in("organ_final.vtu"), &positions);
  const Eigen::Affine3d back = move.inverse();
  Points in_ct(positions.rows(), 3);  // where the organ is in the frame of the second CT
  for (Index v = 0; v < positions.rows(); ++v)
    in_ct.row(v) = (back * Vec3(positions.row(v).transpose())).transpose();

  struct Part {
    const char *name, *file;
    std::vector<Label> labels;
    bool in_mesh;                 ///< its volume is that of tetrahedra …
    std::optional<Label> region;  ///< … of this region, or of all
  };
  const Part parts[] = {
      {"organ", nullptr, {Label::Organ, Label::Tumour, Label::Internal}, true, {}},
      {"internal", "internal_final.vtp", {Label::Internal}, false, {}},
      {"tumour", "tumour_final.vtp", {Label::Tumour}, true, Label::Tumour}};
  ReferenceScores scores;
  double done = 0.1;
  for (const Part& part : parts) {
    progress.ThrowIfCancelled();
    progress.Report(done, std::string("comparing ") + part.name);
    done += 0.3;
    const Mask mask = MaskOf(labels, part.labels);
    const SurfaceMesh reference = MaskSurface(labels.grid, mask, move, labels_file);
    if (reference.Empty()) {
      if (!part.file) throw InputError(labels_file, "labels 1 to 3", "no voxel has them");
      continue;
    }
    SurfaceMesh model;
    if (!part.file)
      model = BoundarySurface(mesh, positions);
    else if (fs::exists(in(part.file)))
      model = ReadSurface(in(part.file));
    if (const auto distance = SampledHausdorff(model, reference, kSamples))
      scores.distance[part.name] = *distance;
    // Organ and tumour are regions of the mesh; an inner structure has a volume only while it is
    // closed.
    if (part.in_mesh)
      scores.volume_dice[part.name] = DiceOf(mask, TetMask(labels.grid, mesh, in_ct, part.region));
    else if (model.IsClosedManifold())
      scores.volume_dice[part.name] = DiceOf(mask, SurfaceMask(labels.grid, move, model, progress));
  }
  return scores;
}

}  // namespace kerf
