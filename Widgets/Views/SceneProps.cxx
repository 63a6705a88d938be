#include "Views/SceneProps.h"

#include <vtkActor.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkContourFilter.h>
#include <vtkCoordinate.h>
#include <vtkDoubleArray.h>
#include <vtkGlyph3D.h>
#include <vtkLookupTable.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkPolyDataNormals.h>
#include <vtkProperty.h>
#include <vtkSphereSource.h>
#include <vtkTextActor.h>
#include <vtkTextProperty.h>

#include "Adapters/Vtk/Conversions.h"

namespace kerf_scene {
namespace {

void Paint(vtkProperty* property, const QColor& color, double opacity) {
  property->SetColor(color.redF(), color.greenF(), color.blueF());
  property->SetOpacity(opacity);
  property->SetAmbient(0.2);
  property->SetSpecular(0.15);
  property->SetSpecularPower(20);
}

vtkSmartPointer<vtkPolyData> Shaded(vtkPolyData* data) {
  vtkNew<vtkPolyDataNormals> normals;
  normals->SetInputData(data);
  normals->SplittingOff();
  normals->ConsistencyOff();
  normals->Update();
  return normals->GetOutput();
}

vtkSmartPointer<vtkDoubleArray> ArrayOf(const std::vector<double>& values) {
  auto array = vtkSmartPointer<vtkDoubleArray>::New();
  array->SetNumberOfTuples(static_cast<vtkIdType>(values.size()));
  for (std::size_t i = 0; i < values.size(); ++i)
    array->SetValue(static_cast<vtkIdType>(i), values[i]);
  return array;
}

vtkSmartPointer<vtkPolyData> PointSet(const kerf::Points& points, bool as_line) {
  auto data = vtkSmartPointer<vtkPolyData>::New();
  vtkNew<vtkPoints> corners;
  corners->SetDataTypeToDouble();
  for (Eigen::Index p = 0; p < points.rows(); ++p)
    corners->InsertNextPoint(points(p, 0), points(p, 1), points(p, 2));
  data->SetPoints(corners);
  if (as_line) {
    vtkNew<vtkCellArray> cells;
    cells->InsertNextCell(static_cast<vtkIdType>(points.rows()));
    for (vtkIdType p = 0; p < points.rows(); ++p) cells->InsertCellPoint(p);
    data->SetLines(cells);
  }
  return data;
}

/// A line that is seen although it lies on a surface.
vtkSmartPointer<vtkProp> LineOver(vtkPolyData* lines, const QColor& color, double width_px) {
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputData(lines);
  mapper->ScalarVisibilityOff();
  mapper->SetResolveCoincidentTopologyToPolygonOffset();
  mapper->SetRelativeCoincidentTopologyLineOffsetParameters(0, -8);
  vtkNew<vtkActor> actor;
  actor->SetMapper(mapper);
  Paint(actor->GetProperty(), color, 1);
  actor->GetProperty()->SetLineWidth(static_cast<float>(width_px));
  actor->GetProperty()->LightingOff();
  return actor.Get();
}

}  // namespace

void FillNearToFar(vtkLookupTable* table) {
  const double stops[5][3] = {
      {0.75, 0.1, 0.15}, {0.95, 0.5, 0.2}, {0.95, 0.85, 0.4}, {0.45, 0.75, 0.75}, {0.2, 0.4, 0.8}};
  table->SetNumberOfTableValues(256);
  for (int i = 0; i < 256; ++i) {
    const double t = i / 255.0 * 4;
    const int s = std::min(3, static_cast<int>(t));
    double rgb[3];
    for (int c = 0; c < 3; ++c) rgb[c] = stops[s][c] + (stops[s + 1][c] - stops[s][c]) * (t - s);
    table->SetTableValue(i, rgb[0], rgb[1], rgb[2], 1);
  }
}

vtkSmartPointer<vtkProp> SurfaceProp(const kerf::SurfaceMesh& surface, const QColor& color,
                                     double opacity) {
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputData(Shaded(kerf::ToVtk(surface)));
  mapper->ScalarVisibilityOff();
  vtkNew<vtkActor> actor;
  actor->SetMapper(mapper);
  Paint(actor->GetProperty(), color, opacity);
  return actor.Get();
}

vtkSmartPointer<vtkProp> ColoredSurfaceProp(const kerf::SurfaceMesh& surface,
                                            const std::vector<double>& values,
                                            vtkLookupTable* table, double opacity) {
  auto data = kerf::ToVtk(surface);
  const bool per_point = values.size() == static_cast<std::size_t>(surface.points.rows());
  if (per_point) {
    data = Shaded(data);
    data->GetPointData()->SetScalars(ArrayOf(values));
  } else {
    data->GetCellData()->SetScalars(ArrayOf(values));
  }
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputData(data);
  mapper->SetLookupTable(table);
  mapper->UseLookupTableScalarRangeOn();
  vtkNew<vtkActor> actor;
  actor->SetMapper(mapper);
  actor->GetProperty()->SetOpacity(opacity);
  return actor.Get();
}

vtkSmartPointer<vtkProp> LineProp(const kerf::Points& points, const QColor& color,
                                  double width_px) {
  return LineOver(PointSet(points, true), color, width_px);
}

vtkSmartPointer<vtkProp> BallsProp(const kerf::Points& points, const QColor& color,
                                   double radius_mm) {
  vtkNew<vtkSphereSource> ball;
  ball->SetRadius(radius_mm);
  ball->SetThetaResolution(16);
  ball->SetPhiResolution(12);
  vtkNew<vtkGlyph3D> glyphs;
  glyphs->SetInputData(PointSet(points, false));
  glyphs->SetSourceConnection(ball->GetOutputPort());
  glyphs->ScalingOff();
  glyphs->Update();
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputData(glyphs->GetOutput());
  vtkNew<vtkActor> actor;
  actor->SetMapper(mapper);
  Paint(actor->GetProperty(), color, 1);
  return actor.Get();
}

vtkSmartPointer<vtkProp> NameProp(const std::string& name, const kerf::Vec3& at_mm) {
  vtkNew<vtkTextActor> text;
  text->SetInput(name.c_str());
  text->GetPositionCoordinate()->SetCoordinateSystemToWorld();
  text->SetPosition(0, 0);
  text->GetPositionCoordinate()->SetValue(at_mm[0], at_mm[1], at_mm[2]);
  text->GetTextProperty()->SetFontSize(14);
  text->GetTextProperty()->SetColor(1, 1, 1);
  text->GetTextProperty()->SetBackgroundColor(0, 0, 0);
  text->GetTextProperty()->SetBackgroundOpacity(0.55);
  return text.Get();
}

vtkSmartPointer<vtkProp> IsolineProp(const kerf::SurfaceMesh& surface,
                                     const std::vector<double>& values, double value,
                                     const QColor& color) {
  auto data = kerf::ToVtk(surface);
  data->GetPointData()->SetScalars(ArrayOf(values));
  vtkNew<vtkContourFilter> contour;
  contour->SetInputData(data);
  contour->SetValue(0, value);
  contour->ComputeNormalsOff();
  contour->Update();
  return LineOver(contour->GetOutput(), color, 3);
}

}  // namespace kerf_scene
