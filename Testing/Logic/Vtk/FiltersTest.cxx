#include <gtest/gtest.h>
#include <vtkCellData.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkUnstructuredGrid.h>

#include "Adapters/Vtk/Conversions.h"
#include "Adapters/Vtk/LabelSurface.h"
#include "Adapters/Vtk/vtkKerfEmbeddedWarp.h"
#include "Adapters/Vtk/vtkKerfLabelMapToTetraGrid.h"
#include "Core/Errors.h"
#include "Logic/Meshing/LabelShapes.h"
#include "Support/TestMeshes.h"

using namespace kerf;
using kerf::testing::LabelsOf;
using kerf::testing::OrganWithTumour;

TEST(LabelMapToTetraGrid, FillsTheLabelsWithTetrahedra) {
  const LabelMap labels = LabelsOf(OrganWithTumour);
  vtkNew<vtkKerfLabelMapToTetraGrid> filter;
  filter->SetInputData(ToVtk(labels));
  filter->SetTetrahedra(2000);
  filter->Update();
  vtkUnstructuredGrid* grid = filter->GetOutput();
  EXPECT_NEAR(grid->GetNumberOfCells(), 2000, 300);
  ASSERT_TRUE(grid->GetCellData()->GetArray("region"));
  ASSERT_TRUE(grid->GetPointData()->GetArray("rest_position_mm"));
  const TetMesh mesh = TetMeshFromVtk(grid, "grid");
  EXPECT_NEAR(MeasureQuality(mesh, mesh.rest).volume_mm3 / filter->GetReport().input_volume_mm3,
              1.0, 0.01);
  EXPECT_NO_THROW(filter->RethrowError());
  const auto before = grid->GetMTime();
  filter->Update();
  EXPECT_EQ(filter->GetOutput()->GetMTime(), before) << "nothing changed, nothing is done again";
}

TEST(LabelMapToTetraGrid, EmptyLabelsGiveAnEmptyGridAndTheReason) {
  const LabelMap labels = LabelsOf([](const Vec3&) { return Label::Background; }, 8);
  kerf::testing::RecordedProgress sink;
  vtkNew<vtkKerfLabelMapToTetraGrid> filter;
  filter->SetProgressSink(&sink);
  filter->SetSourceName("empty.nrrd");
  filter->SetInputData(ToVtk(labels));
  filter->Update();
  EXPECT_EQ(filter->GetOutput()->GetNumberOfCells(), 0);
  try {
    filter->RethrowError();
    FAIL();
  } catch (const InputError& error) {
    EXPECT_EQ(error.File(), "empty.nrrd");
  }
}

TEST(LabelMapToTetraGrid, PrintsItself) {
  vtkNew<vtkKerfLabelMapToTetraGrid> filter;
  std::ostringstream text;
  filter->Print(text);
  EXPECT_NE(text.str().find("Tetrahedra: 15000"), std::string::npos);
}

TEST(EmbeddedWarp, CarriesTheSurfaceAlongAnAffineMapExactly) {
  const TetMesh mesh = kerf::testing::BoxMesh({20, 20, 20}, 4, 4, 4);
  const SurfaceMesh sphere = kerf::testing::SphereSurface({0, 0, 0}, 7, 2);
  Mat3 a;
  a << 1.1, 0.2, 0.0, -0.1, 0.9, 0.3, 0.0, 0.1, 1.2;
  vtkNew<vtkKerfEmbeddedWarp> warp;
  warp->SetInputData(ToVtk(sphere));
  warp->SetGridData(ToVtk(mesh, mesh.rest * a.transpose()));
  warp->Update();
  const SurfaceMesh out = SurfaceFromVtk(warp->GetOutput(), "out");
  EXPECT_LT((out.points - sphere.points * a.transpose()).cwiseAbs().maxCoeff(), 1e-10);
  EXPECT_EQ(out.triangles, sphere.triangles);
  EXPECT_EQ(warp->GetNumberOfPointsOutside(), 0);
  Points rest;
  ASSERT_TRUE(RestPositionsFromVtk(warp->GetOutput(), &rest));
  EXPECT_EQ(rest, sphere.points);
}

TEST(EmbeddedWarp, SearchesOnlyWhenRestOrCellsChange) {
  const TetMesh mesh = kerf::testing::BoxMesh({20, 20, 20}, 3, 3, 3);
  vtkNew<vtkKerfEmbeddedWarp> warp;
  warp->SetInputData(ToVtk(kerf::testing::SphereSurface({0, 0, 0}, 7, 2)));
  for (double scale : {1.0, 1.1, 1.2}) {
    warp->SetGridData(ToVtk(mesh, mesh.rest * scale));
    warp->Update();
  }
  EXPECT_EQ(warp->GetEmbeddingCount(), 1);
  const TetMesh finer = kerf::testing::BoxMesh({20, 20, 20}, 4, 4, 4);
  warp->SetGridData(ToVtk(finer));
  warp->Update();
  EXPECT_EQ(warp->GetEmbeddingCount(), 2);
}

TEST(EmbeddedWarp, CountsPointsOutside) {
  const TetMesh mesh = kerf::testing::BoxMesh({20, 20, 20}, 3, 3, 3);
  vtkNew<vtkKerfEmbeddedWarp> warp;
  warp->SetInputData(ToVtk(kerf::testing::SphereSurface({0, 0, 0}, 11, 1)));
  warp->SetGridData(ToVtk(mesh));
  warp->Update();
  EXPECT_GT(warp->GetNumberOfPointsOutside(), 0);
}

TEST(LabelSurface, IsClosedAndLiesOnTheShapeBelowVoxelSize) {
  const LabelMap labels = LabelsOf(OrganWithTumour);
  const SurfaceMesh tumour = SurfaceOfField(SmoothLabel(labels, Label::Tumour), "l");
  EXPECT_TRUE(tumour.IsClosedManifold());
  EXPECT_NEAR(tumour.SignedVolume() / labels.LabelVolume_mm3(Label::Tumour), 1.0, 0.06);
  const Eigen::RowVector3d center(36, -17, 100);
  const Eigen::VectorXd radius = (tumour.points.rowwise() - center).rowwise().norm();
  EXPECT_LT((radius.array() - 4.5).abs().mean(), 0.25);
  const SurfaceMesh tube = SurfaceOfField(SmoothLabel(labels, Label::Internal), "l");
  EXPECT_TRUE(tube.IsClosedManifold());
  EXPECT_EQ(tube.Components(), 1);
  EXPECT_NEAR(tube.SignedVolume() / labels.LabelVolume_mm3(Label::Internal), 1.0, 0.1);
}

TEST(LabelSurface, HasNoMorePointsThanAsked) {
  const LabelMap labels = LabelsOf(OrganWithTumour);
  const SurfaceMesh fine = SurfaceOfField(SmoothLabel(labels, Label::Organ), "l");
  const SurfaceMesh coarse = SurfaceOfField(SmoothLabel(labels, Label::Organ), "l", 800);
  EXPECT_LE(coarse.points.rows(), 800);
  EXPECT_TRUE(coarse.IsClosedManifold());
  EXPECT_NEAR(coarse.SignedVolume() / fine.SignedVolume(), 1.0, 0.05);
  EXPECT_THROW(SurfaceOfField(LabelField{}, "l"), InputError);
}
