#include <array>
#include <filesystem>

#include "Adapters/Itk/VolumeFiles.h"
#include "Adapters/Vtk/LabelSurface.h"
#include "Adapters/Vtk/MeshFiles.h"
#include "CaseIO/TransformFile.h"
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

/// Dice of the voxels of a mask and those whose centre lies inside a closed surface, on the grid of
/// the mask.
double VolumeDice(const GridGeometry& grid, const Mask& mask, const Eigen::Affine3d& move,
                  const SurfaceMesh& closed, Progress& progress) {
  const SurfaceTree tree(closed);
  const Vec3 low = closed.points.colwise().minCoeff().transpose();
  const Vec3 high = closed.points.colwise().maxCoeff().transpose();
  std::size_t both = 0, sum = 0;
  for (int k = 0; k < grid.size[2]; ++k) {
    progress.ThrowIfCancelled();
    for (int j = 0; j < grid.size[1]; ++j)
      for (int i = 0; i < grid.size[0]; ++i) {
        const Vec3 p = move * grid.WorldFromIndex(Vec3(i, j, k));
        const bool in_mask = mask[grid.Offset(i, j, k)] != 0;
        const bool inside =
            (p.array() >= low.array()).all() && (p.array() <= high.array()).all() && tree.Inside(p);
        both += in_mask && inside;
        sum += std::size_t(in_mask) + std::size_t(inside);
      }
  }
  return sum == 0 ? 1.0 : 2.0 * static_cast<double>(both) / static_cast<double>(sum);
}

/// Outer surface, as deformed, of the tetrahedra of some regions.
SurfaceMesh RegionSurface(const TetMesh& mesh, const Points& positions, const Label* only) {
  TetMesh part;
  part.rest = mesh.rest;
  part.tets.resize(mesh.TetCount(), 4);
  Index count = 0;
  for (Index t = 0; t < mesh.TetCount(); ++t)
    if (!only || mesh.region[t] == static_cast<std::uint8_t>(*only))
      part.tets.row(count++) = mesh.tets.row(t);
  part.tets.conservativeResize(count, 4);
  return BoundarySurface(part, positions);
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

  struct Part {
    const char *name, *file;
    std::vector<Label> labels;
  };
  const Part parts[] = {{"organ", nullptr, {Label::Organ, Label::Tumour, Label::Internal}},
                        {"internal", "internal_final.vtp", {Label::Internal}},
                        {"tumour", "tumour_final.vtp", {Label::Tumour}}};
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
      model = RegionSurface(mesh, positions, nullptr);
    else if (fs::exists(in(part.file)))
      model = ReadSurface(in(part.file));
    if (const auto distance = SampledHausdorff(model, reference, kSamples))
      scores.distance[part.name] = *distance;
    // A structure that was cut is open: of the tumour the tetrahedra still tell the volume.
    const Label tumour = Label::Tumour;
    if (std::string(part.name) == "tumour") model = RegionSurface(mesh, positions, &tumour);
    if (model.IsClosedManifold())
      scores.volume_dice[part.name] = VolumeDice(labels.grid, mask, move, model, progress);
  }
  return scores;
}

}  // namespace kerf
