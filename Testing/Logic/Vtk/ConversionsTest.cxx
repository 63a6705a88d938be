#include <gtest/gtest.h>
#include <vtkCellArray.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkUnstructuredGrid.h>

#include "Adapters/Vtk/Conversions.h"
#include "Core/Errors.h"
#include "Support/TestMeshes.h"

using namespace kerf;

TEST(Conversions, SurfaceRoundTripIsExact) {
  const SurfaceMesh sphere = kerf::testing::SphereSurface({1, 2, 3}, 10, 2);
  const Points rest = sphere.points * 0.5;
  const auto data = ToVtk(sphere, &rest);
  const SurfaceMesh back = SurfaceFromVtk(data, "s");
  EXPECT_EQ(back.points, sphere.points);
  EXPECT_EQ(back.triangles, sphere.triangles);
  Points rest_back;
  ASSERT_TRUE(RestPositionsFromVtk(data, &rest_back));
  EXPECT_EQ(rest_back, rest);
  EXPECT_FALSE(RestPositionsFromVtk(ToVtk(sphere), &rest_back));
}

TEST(Conversions, TetMeshRoundTripKeepsRestPositionsAndRegions) {
  TetMesh mesh = kerf::testing::BoxMesh({10, 10, 10}, 2, 2, 2);
  kerf::testing::PaintSphere({0, 0, 0}, 3, Label::Tumour, &mesh);
  const Points moved = mesh.rest * 1.1;
  Points positions;
  const TetMesh back = TetMeshFromVtk(ToVtk(mesh, moved), "m", &positions);
  EXPECT_EQ(back.rest, mesh.rest);
  EXPECT_EQ(back.tets, mesh.tets);
  EXPECT_EQ(back.region, mesh.region);
  EXPECT_EQ(positions, moved);
}

TEST(Conversions, LabelMapRoundTripKeepsAnObliqueAnisotropicGrid) {
  LabelMap labels;
  labels.grid.size = {3, 4, 5};
  labels.grid.spacing_mm = {0.7, 1.1, 2.5};
  labels.grid.origin_mm = {-12, 30, 7};
  labels.grid.direction =
      (Eigen::AngleAxisd(0.5, Vec3::UnitX()) * Eigen::AngleAxisd(1.1, Vec3::UnitZ()))
          .toRotationMatrix();
  auto voxels = std::make_shared<std::vector<std::uint8_t>>(60);
  for (int i = 0; i < 60; ++i) (*voxels)[i] = static_cast<std::uint8_t>(i);
  labels.voxels = voxels;
  const auto image = ToVtk(labels);
  const LabelMap back = LabelMapFromVtk(image, "l");
  EXPECT_TRUE(back.grid.SameAs(labels.grid, 1e-12));
  EXPECT_EQ(*back.voxels, *labels.voxels);
  // VTK's own idea of where a voxel lies agrees.
  double world[3];
  image->TransformIndexToPhysicalPoint(2, 1, 3, world);
  EXPECT_LT((Vec3(world) - labels.grid.WorldFromIndex({2, 1, 3})).norm(), 1e-12);
}

TEST(Conversions, ImageExtentThatDoesNotBeginAtZeroIsUnderstood) {
  vtkNew<vtkImageData> image;
  image->SetExtent(2, 4, 3, 5, 1, 2);
  image->SetSpacing(1, 2, 3);
  image->SetOrigin(10, 20, 30);
  image->AllocateScalars(VTK_SHORT, 1);
  const Volume volume = VolumeFromVtk(image, "v");
  EXPECT_EQ(volume.grid.origin_mm, Vec3(12, 26, 33));
  EXPECT_EQ(volume.grid.size, Eigen::Vector3i(3, 3, 2));
}

TEST(Conversions, PolygonsAreTriangulatedAndBadIndicesRefused) {
  vtkNew<vtkPolyData> data;
  vtkNew<vtkPoints> points;
  points->InsertNextPoint(0, 0, 0);
  points->InsertNextPoint(1, 0, 0);
  points->InsertNextPoint(1, 1, 0);
  points->InsertNextPoint(0, 1, 0);
  vtkNew<vtkCellArray> quad;
  quad->InsertNextCell({0, 1, 2, 3});
  data->SetPoints(points);
  data->SetPolys(quad);
  EXPECT_EQ(SurfaceFromVtk(data, "q").triangles.rows(), 2);
  vtkNew<vtkCellArray> broken;
  broken->InsertNextCell({0, 1, 9});
  data->SetPolys(broken);
  EXPECT_THROW(SurfaceFromVtk(data, "q"), InputError);
}

TEST(Conversions, OtherCellsAndInvertedTetrahedraAreRefused) {
  TetMesh mesh = kerf::testing::BoxMesh({1, 1, 1}, 1, 1, 1);
  std::swap(mesh.tets(3, 0), mesh.tets(3, 1));
  try {
    TetMeshFromVtk(ToVtk(mesh), "m.vtu");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_EQ(error.Element(), "tetrahedron 3");
  }
}
