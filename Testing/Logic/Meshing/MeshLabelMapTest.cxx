#include <gtest/gtest.h>

#include "LabelShapes.h"
#include "Meshing/LabelField.h"
#include "Meshing/TetMesher.h"

using namespace kerf;
using kerf::testing::LabelsOf;
using kerf::testing::OrganWithTumour;
using kerf::testing::RecordedProgress;

namespace {

double RegionVolume_mm3(const TetMesh& mesh, Label label) {
  double volume = 0.0;
  for (Index t = 0; t < mesh.TetCount(); ++t)
    if (mesh.region[t] == static_cast<std::uint8_t>(label))
      volume += TetVolume(mesh.rest, mesh.tets, t);
  return volume;
}

MeshingOptions Wanted(int tetrahedra) {
  MeshingOptions options;
  options.tetrahedra = tetrahedra;
  return options;
}

}  // namespace

TEST(MeshLabelMap, MeetsCountVolumeAndQualityAndKeepsTheTumour) {
  const LabelMap labels = LabelsOf(OrganWithTumour);
  RecordedProgress progress;
  MeshingReport report;
  const TetMesh mesh = MeshLabelMap(labels, Wanted(4000), progress, &report);
  mesh.Validate("mesh");
  EXPECT_NEAR(mesh.TetCount(), 4000, 600);
  const double voxels_mm3 = labels.LabelVolume_mm3(Label::Organ) +
                            labels.LabelVolume_mm3(Label::Tumour) +
                            labels.LabelVolume_mm3(Label::Internal);
  EXPECT_NEAR(report.input_volume_mm3, voxels_mm3, 1e-6 * voxels_mm3);
  EXPECT_NEAR(report.quality.volume_mm3 / voxels_mm3, 1.0, 0.01);
  EXPECT_NEAR(report.quality.volume_mm3 / (4.0 / 3.0 * M_PI * 18 * 15 * 13), 1.0, 0.02);
  EXPECT_GE(report.quality.smallest_dihedral_deg, 8.0);
  EXPECT_TRUE(report.quality.manifold_boundary);
  EXPECT_EQ(report.quality.components, 1);
  EXPECT_EQ(report.quality.orphans, 0);
  const double tumour_mm3 = labels.LabelVolume_mm3(Label::Tumour);
  EXPECT_NEAR(RegionVolume_mm3(mesh, Label::Tumour) / tumour_mm3, 1.0, 0.12);
  // Only organ and tumour are regions: the inner structure is embedded, not meshed.
  for (const std::uint8_t region : mesh.region) EXPECT_TRUE(region == 1 || region == 2);
}

TEST(MeshLabelMap, SurfaceLiesOnTheShapeBelowVoxelSize) {
  RecordedProgress progress;
  const TetMesh mesh = MeshLabelMap(LabelsOf(OrganWithTumour), Wanted(4000), progress);
  const SurfaceMesh surface = BoundarySurface(mesh, mesh.rest);
  double sum = 0.0;
  for (Index i = 0; i < surface.points.rows(); ++i) {
    const Vec3 x = surface.points.row(i).transpose() - Vec3(30, -20, 100);
    const Vec3 q = x.cwiseQuotient(Vec3(18, 15, 13));
    // Distance to first order: (|q| − 1) / |∇|q||.
    const Vec3 gradient = q.cwiseQuotient(Vec3(18, 15, 13)) / q.norm();
    sum += std::abs(q.norm() - 1.0) / gradient.norm();
  }
  EXPECT_LT(sum / surface.points.rows(), 0.25);
  EXPECT_TRUE(surface.IsClosedManifold());
  EXPECT_GT(surface.SignedVolume(), 0.0);
}

TEST(MeshLabelMap, TwoRunsGiveTheSameBits) {
  const LabelMap labels = LabelsOf(OrganWithTumour);
  RecordedProgress progress;
  const TetMesh a = MeshLabelMap(labels, Wanted(2000), progress);
  const TetMesh b = MeshLabelMap(labels, Wanted(2000), progress);
  ASSERT_EQ(a.TetCount(), b.TetCount());
  EXPECT_TRUE((a.tets.array() == b.tets.array()).all());
  EXPECT_TRUE((a.rest.array() == b.rest.array()).all());
  EXPECT_EQ(a.region, b.region);
}

TEST(MeshLabelMap, LeftHandedGridGivesPositiveTetrahedra) {
  RecordedProgress progress;
  const TetMesh mesh =
      MeshLabelMap(LabelsOf(OrganWithTumour, 44, {1.0, 1.1, 1.3}, true), Wanted(1500), progress);
  EXPECT_NO_THROW(mesh.Validate("mesh"));
}

TEST(MeshLabelMap, TumourAtTheSurfaceKeepsItsQuality) {
  const auto exophytic = [](const Vec3& x) {
    if ((x - Vec3(15, 0, 0)).norm() < 6.0) return Label::Tumour;
    return x.norm() < 15.0 ? Label::Organ : Label::Background;
  };
  RecordedProgress progress;
  MeshingReport report;
  const LabelMap labels = LabelsOf(exophytic, 52);
  const TetMesh mesh = MeshLabelMap(labels, Wanted(5000), progress, &report);
  EXPECT_GE(report.quality.smallest_dihedral_deg, 8.0);
  EXPECT_TRUE(report.quality.manifold_boundary);
  EXPECT_NEAR(RegionVolume_mm3(mesh, Label::Tumour) / labels.LabelVolume_mm3(Label::Tumour), 1.0,
              0.1);
}

TEST(MeshLabelMap, FillsCavitiesAndDropsIslandsAndSaysSo) {
  const auto shape = [](const Vec3& x) {
    if (x.norm() < 4.0) return Label::Background;  // cavity
    if (x.norm() < 12.0) return Label::Organ;
    if ((x - Vec3(18, 0, 0)).norm() < 2.0) return Label::Organ;  // island
    return Label::Background;
  };
  RecordedProgress progress;
  MeshingReport report;
  MeshLabelMap(LabelsOf(shape), Wanted(1500), progress, &report);
  EXPECT_TRUE(progress.Warned("cavities"));
  EXPECT_TRUE(progress.Warned("apart from the organ"));
  EXPECT_NEAR(report.quality.volume_mm3 / (4.0 / 3.0 * M_PI * 12 * 12 * 12), 1.0, 0.02);
}

TEST(MeshLabelMap, OrganThatTouchesTheBorderIsClosedThere) {
  RecordedProgress progress;
  MeshingReport report;
  MeshLabelMap(LabelsOf([](const Vec3& x) { return x.z() > 3 ? Label::Organ : Label::Background; },
                        24, {1.2, 1.2, 1.2}),
               Wanted(1500), progress, &report);
  EXPECT_TRUE(report.quality.manifold_boundary);
}

TEST(MeshLabelMap, RefusesEmptyLabelsNamingTheFile) {
  RecordedProgress progress;
  try {
    MeshLabelMap(LabelsOf([](const Vec3&) { return Label::Background; }, 10), Wanted(1000),
                 progress);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_EQ(error.File(), "made-up.nii.gz");
    EXPECT_EQ(error.Element(), "labels");
  }
}

TEST(MeshLabelMap, RefusesNanSpacingAndWrongVoxelCount) {
  RecordedProgress progress;
  LabelMap labels = LabelsOf(OrganWithTumour, 12);
  labels.grid.spacing_mm[1] = std::nan("");
  EXPECT_THROW(MeshLabelMap(labels, Wanted(1000), progress), InputError);
  labels = LabelsOf(OrganWithTumour, 12);
  labels.grid.size[0] = 13;
  EXPECT_THROW(MeshLabelMap(labels, Wanted(1000), progress), InputError);
}

TEST(MeshLabelMap, IsCancelled) {
  RecordedProgress progress;
  progress.cancelled = true;
  EXPECT_THROW(MeshLabelMap(LabelsOf(OrganWithTumour), Wanted(4000), progress), Cancelled);
}

TEST(LabelField, KeepsVolumeAndThinTubes) {
  // A tube two voxels across would lose a third to a Gaussian alone.
  const auto tube = [](const Vec3& x) {
    return Vec3(x.x(), x.y(), 0).norm() < 1.6 && std::abs(x.z()) < 15 ? Label::Internal
                                                                      : Label::Background;
  };
  const LabelMap labels = LabelsOf(tube, 44, {1, 1, 1});
  const LabelField field = SmoothLabel(labels, Label::Internal);
  ASSERT_FALSE(field.Empty());
  // Volume of {field > level} by sampling at a quarter of a voxel.
  double inside = 0.0;
  const double h = 0.25;
  for (double x = -4; x < 4; x += h)
    for (double y = -4; y < 4; y += h)
      for (double z = -18; z < 18; z += h) inside += field.Inside(Vec3(30 + x, -20 + y, 100 + z));
  EXPECT_NEAR(inside * h * h * h / labels.LabelVolume_mm3(Label::Internal), 1.0, 0.08);
  EXPECT_EQ(InteriorSeeds(field).size(), 1U);
  EXPECT_EQ(field.At(Vec3(1e4, 0, 0)), 0.0);
}
