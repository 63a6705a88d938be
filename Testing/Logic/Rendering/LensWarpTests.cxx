// vtkKerfLensWarp as a filter, alone and behind vtkKerfEmbeddedWarp.

#include <gtest/gtest.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkIdList.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkUnsignedCharArray.h>
#include <vtkUnstructuredGrid.h>

#include <sstream>

#include "Adapters/Rendering/vtkKerfLensWarp.h"
#include "Adapters/Vtk/Conversions.h"
#include "Adapters/Vtk/vtkKerfEmbeddedWarp.h"
#include "Core/TetMesh.h"
#include "SceneFixtures.h"

namespace kerf {
namespace {

Vec2 Pixel(const CameraModel& ideal, vtkPolyData* output, vtkIdType i) {
  Vec3 p;
  output->GetPoint(i, p.data());
  return ideal.Project(p);
}

TEST(LensWarp, OutputPointsLieOnTheDistortedPixels) {
  const CameraModel lens = testing::StrongLens();
  const SurfaceMesh ball = testing::Sphere(lens.PointAtDepth({850, 60}, 120), Vec3::Constant(6), 2);
  vtkNew<vtkKerfLensWarp> warp;
  warp->SetLens(lens);
  warp->SetInputData(ToVtk(ball));
  warp->Update();
  vtkPolyData* out = warp->GetOutput();
  ASSERT_EQ(out->GetNumberOfPoints(), ball.points.rows());
  ASSERT_EQ(out->GetNumberOfPolys(), ball.triangles.rows());
  // Points come in the order of the triangles that use them: compare corner by corner.
  vtkNew<vtkIdList> ids;
  for (Index t = 0; t < ball.triangles.rows(); ++t) {
    out->GetPolys()->GetCellAtId(t, ids);
    for (int k = 0; k < 3; ++k) {
      const Vec2 expected = lens.Project(ball.points.row(ball.triangles(t, k)).transpose());
      EXPECT_LT((Pixel(warp->GetIdealPinhole(), out, ids->GetId(k)) - expected).norm(), 1e-3);
    }
  }
}

TEST(LensWarp, CutFacesGetVerticesOfTheirOwn) {
  const CameraModel lens = testing::StrongLens();
  const SurfaceMesh ball =
      testing::Sphere(lens.PointAtDepth({480, 270}, 120), Vec3::Constant(6), 1);
  vtkSmartPointer<vtkPolyData> data = ToVtk(ball);
  vtkNew<vtkUnsignedCharArray> flags;
  flags->SetName("cut_face");
  flags->SetNumberOfTuples(ball.triangles.rows());
  flags->Fill(0);
  flags->SetValue(5, 1);
  data->GetCellData()->AddArray(flags);
  vtkNew<vtkKerfLensWarp> warp;
  warp->SetLens(lens);
  warp->SetSurfaceClass(7);
  warp->SetInputData(data);
  warp->Update();
  EXPECT_EQ(warp->GetOutput()->GetNumberOfPoints(), ball.points.rows() + 3);
  int cut = 0;
  vtkDataArray* buffer = warp->GetOutput()->GetPointData()->GetScalars();
  for (vtkIdType i = 0; i < buffer->GetNumberOfTuples(); ++i) {
    const int surface = static_cast<int>(buffer->GetComponent(i, 1));
    EXPECT_TRUE(surface == 7 || surface == 2);
    cut += surface == 2;
  }
  EXPECT_EQ(cut, 3);
  flags->Fill(0);  // the cut is taken back
  flags->Modified();
  data->Modified();
  warp->Update();
  EXPECT_EQ(warp->GetOutput()->GetNumberOfPoints(), ball.points.rows());
}

TEST(LensWarp, TrianglesBehindTheLensAreLeftOutAndComeBack) {
  CameraModel lens = testing::StrongLens();
  const SurfaceMesh around = testing::Sphere(lens.Center(), Vec3::Constant(50), 3);
  vtkNew<vtkKerfLensWarp> warp;
  warp->SetLens(lens);
  warp->SetInputData(ToVtk(around));
  warp->Update();
  const vtkIdType seen = warp->GetOutput()->GetNumberOfPolys();
  EXPECT_GT(seen, 100);
  EXPECT_LT(seen, around.triangles.rows());
  EXPECT_GE(warp->GetDepthRange()[0], vtkKerfLensWarp::NearestDepth);
  lens.camera_from_world.translation().z() += 100;
  warp->SetLens(lens);
  warp->Update();
  EXPECT_EQ(warp->GetOutput()->GetNumberOfPolys(), around.triangles.rows());
}

TEST(LensWarp, OnlyOfASolidBeforeTheLensNobodySeesTheBack) {
  const CameraModel lens = testing::StrongLens();
  const auto is_solid = [&](const SurfaceMesh& mesh, bool with_cut = false) {
    vtkSmartPointer<vtkPolyData> data = ToVtk(mesh);
    vtkNew<vtkUnsignedCharArray> flags;
    flags->SetName("cut_face");
    flags->SetNumberOfTuples(mesh.triangles.rows());
    flags->Fill(0);
    flags->SetValue(5, with_cut);
    data->GetCellData()->AddArray(flags);
    vtkNew<vtkKerfLensWarp> warp;
    warp->SetLens(lens);
    warp->SetInputData(data);
    warp->Update();
    return warp->GetSolid();
  };
  const SurfaceMesh ball =
      testing::Sphere(lens.PointAtDepth({480, 270}, 120), Vec3::Constant(6), 2);
  EXPECT_TRUE(is_solid(ball));
  EXPECT_TRUE(is_solid(ball, true)) << "faces of a cut belong to it";
  SurfaceMesh open = ball;
  open.triangles.conservativeResize(open.triangles.rows() - 1, 3);
  EXPECT_FALSE(is_solid(open));
  SurfaceMesh inside_out = ball;
  inside_out.triangles.col(0).swap(inside_out.triangles.col(1));
  EXPECT_FALSE(is_solid(inside_out));
  EXPECT_FALSE(is_solid(testing::Sphere(lens.Center(), Vec3::Constant(50), 3)));
}

TEST(LensWarp, EmptyInputGivesEmptyOutput) {
  vtkNew<vtkKerfLensWarp> warp;
  warp->SetLens(testing::StrongLens());
  vtkNew<vtkPolyData> empty;
  warp->SetInputData(empty);
  warp->Update();
  EXPECT_EQ(warp->GetOutput()->GetNumberOfPoints(), 0);
  std::ostringstream text;
  warp->Print(text);
  EXPECT_NE(text.str().find("DepthRange"), std::string::npos);
}

// A structure that is embedded in a moving grid goes through both filters: the pipeline of a live
// view.
TEST(LensWarp, FollowsAnEmbeddedStructure) {
  TetMesh tet;
  tet.rest.resize(4, 3);
  tet.rest << 0, 0, 0, 60, 0, 0, 0, 60, 0, 0, 0, 60;
  tet.tets.resize(1, 4);
  tet.tets << 0, 1, 2, 3;
  tet.region = {1};
  const SurfaceMesh rest = testing::Sphere({12, 12, 12}, Vec3::Constant(5), 2);
  Mat3 stretch = Mat3::Identity();
  stretch(0, 0) = 1.3;
  stretch(0, 1) = 0.2;
  const Vec3 shift(-10, 3, 4);
  Points moved = (tet.rest * stretch.transpose()).rowwise() + shift.transpose();

  const CameraModel lens = testing::StrongLens();
  vtkNew<vtkKerfEmbeddedWarp> embedded;
  embedded->SetInputData(0, ToVtk(rest));
  embedded->SetGridData(ToVtk(tet, moved));
  vtkNew<vtkKerfLensWarp> warp;
  warp->SetLens(lens);
  warp->SetInputConnection(embedded->GetOutputPort());
  warp->Update();
  vtkNew<vtkIdList> ids;
  for (Index t = 0; t < rest.triangles.rows(); t += 7) {
    warp->GetOutput()->GetPolys()->GetCellAtId(t, ids);
    const Vec3 p = stretch * Vec3(rest.points.row(rest.triangles(t, 0)).transpose()) + shift;
    EXPECT_LT(
        (Pixel(warp->GetIdealPinhole(), warp->GetOutput(), ids->GetId(0)) - lens.Project(p)).norm(),
        1e-3);
  }
}

}  // namespace
}  // namespace kerf
