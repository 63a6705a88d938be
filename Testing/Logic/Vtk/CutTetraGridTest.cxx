#include <gtest/gtest.h>
#include <vtkCellData.h>
#include <vtkDoubleArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkUnstructuredGrid.h>

#include "Adapters/Vtk/Conversions.h"
#include "Adapters/Vtk/vtkKerfCutTetraGrid.h"
#include "Support/TestMeshes.h"

namespace kerf::testing {
namespace {

vtkSmartPointer<vtkPolyData> PlaneX(double x) {
  const CutSurface s = RectangleCut({x, -50, -50}, {0, 100, 0}, {0, 0, 100}, 30, 30);
  return ToVtk(SurfaceMesh{s.points, s.triangles});
}

/// x of the rest position as a point array, the number of the cell as a cell array.
vtkSmartPointer<vtkUnstructuredGrid> GridWithArrays(const TetMesh& mesh, const Points& positions) {
  auto grid = ToVtk(mesh, positions);
  vtkNew<vtkDoubleArray> x, number;
  x->SetName("x");
  number->SetName("number");
  for (Index v = 0; v < mesh.VertexCount(); ++v) x->InsertNextValue(mesh.rest(v, 0));
  for (Index t = 0; t < mesh.TetCount(); ++t) number->InsertNextValue(t);
  grid->GetPointData()->AddArray(x);
  grid->GetCellData()->AddArray(number);
  return grid;
}

TEST(CutTetraGrid, CutsADeformedGridAndCarriesArraysOver) {
  const TetMesh mesh = SphereMesh(30, 4);
  const Points positions = 1.1 * mesh.rest;
  vtkNew<vtkKerfCutTetraGrid> filter;
  filter->SetInputData(GridWithArrays(mesh, positions));
  filter->SetSurfaceData(PlaneX(1.3));
  filter->Update();
  ASSERT_TRUE(filter->GetCut()) << filter->GetReason();
  EXPECT_EQ(filter->GetNumberOfComponents(), 2);
  vtkUnstructuredGrid* cut = filter->GetOutput();
  Points now;
  const TetMesh out = TetMeshFromVtk(cut, "cut", &now);
  EXPECT_EQ(MeasureQuality(out, out.rest).components, 2);
  EXPECT_LT((now - 1.1 * out.rest).cwiseAbs().maxCoeff(), 1e-9);
  vtkDataArray* x = cut->GetPointData()->GetArray("x");
  ASSERT_NE(x, nullptr);
  for (Index v = 0; v < out.VertexCount(); ++v) EXPECT_NEAR(x->GetTuple1(v), out.rest(v, 0), 1e-9);
  vtkDataArray* number = cut->GetCellData()->GetArray("number");
  ASSERT_NE(number, nullptr);
  EXPECT_EQ(number->GetNumberOfTuples(), out.TetCount());
}

TEST(CutTetraGrid, BoundsThatCannotBeKeptRefuseTheCut) {
  const TetMesh mesh = SphereMesh(30, 4);
  vtkNew<vtkKerfCutTetraGrid> filter;
  filter->SetInputData(ToVtk(mesh));
  filter->SetSurfaceData(PlaneX(1.3));
  filter->SetMaximumNewVertices(0.0);
  filter->Update();
  EXPECT_FALSE(filter->GetCut());
  EXPECT_NE(std::string(filter->GetReason()), "");
  filter->SetMaximumNewVertices(4.0);
  filter->SetMinimumVolumeShare(0.9);
  filter->Update();
  EXPECT_FALSE(filter->GetCut());
  filter->SetMinimumVolumeShare(1e-7);
  filter->Update();
  EXPECT_TRUE(filter->GetCut()) << filter->GetReason();
}

TEST(CutTetraGrid, OutputCanBeCutAgain) {
  const TetMesh mesh = SphereMesh(30, 4);
  vtkNew<vtkKerfCutTetraGrid> first, second, third;
  first->SetInputData(ToVtk(mesh));
  first->SetSurfaceData(PlaneX(1.3));
  second->SetInputConnection(first->GetOutputPort());
  second->SetSurfaceData(PlaneX(-11.2));
  third->SetInputConnection(second->GetOutputPort());
  third->SetSurfaceData(PlaneX(1.3));
  third->Update();
  EXPECT_EQ(second->GetNumberOfComponents(), 3);
  EXPECT_FALSE(third->GetCut());
  EXPECT_NE(std::string(third->GetReason()), "");
}

TEST(CutTetraGrid, PassesThroughWhereNothingIsCut) {
  const TetMesh mesh = SphereMesh(30, 3);
  vtkNew<vtkKerfCutTetraGrid> filter;
  filter->SetInputData(ToVtk(mesh));
  filter->SetSurfaceData(PlaneX(80));
  filter->Update();
  EXPECT_FALSE(filter->GetCut());
  EXPECT_EQ(filter->GetOutput()->GetNumberOfCells(), mesh.TetCount());
}

}  // namespace
}  // namespace kerf::testing
