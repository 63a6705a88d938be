#include "Adapters/Rendering/ErrorMap.h"

#include <vtkActor.h>
#include <vtkCamera.h>
#include <vtkCellArray.h>
#include <vtkColorTransferFunction.h>
#include <vtkDoubleArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkPolyDataNormals.h>
#include <vtkProperty.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkScalarBarActor.h>
#include <vtkTextProperty.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "Adapters/Rendering/DisplayProbe.h"
#include "Adapters/Rendering/VirtualDisplay.h"

// As in GeometryBuffers.cxx: whoever links this alone has VTK's factories, too.
#include <vtkAutoInit.h>
VTK_MODULE_INIT(vtkRenderingOpenGL2)
VTK_MODULE_INIT(vtkRenderingFreeType)

namespace kerf {
namespace {

constexpr double kMargin = 1.08;         // of the surface's half height
constexpr double kScaleFraction = 0.14;  // of the picture's width, on its right
constexpr int kText_px = 16;
constexpr double kFeatureAngle_deg = 60.0;  // lips of a cut stay sharp

/// Yellow-orange-red of ColorBrewer: the lightness tells the error, in print and to the
/// colour-blind.
vtkNew<vtkColorTransferFunction> Colours(double largest_mm) {
  constexpr double kStops[][3] = {{1.00, 1.00, 0.80},
                                  {1.00, 0.85, 0.46},
                                  {0.99, 0.55, 0.24},
                                  {0.89, 0.10, 0.11},
                                  {0.50, 0.00, 0.15}};
  vtkNew<vtkColorTransferFunction> colours;
  for (int i = 0; i < 5; ++i)
    colours->AddRGBPoint(largest_mm * i / 4.0, kStops[i][0], kStops[i][1], kStops[i][2]);
  colours->SetNanColor(0.6, 0.6, 0.6);
  return colours;
}

vtkNew<vtkPolyData> Data(const SurfaceMesh& surface, const Eigen::VectorXd& error_mm) {
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  for (Index v = 0; v < surface.points.rows(); ++v)
    points->InsertNextPoint(surface.points(v, 0), surface.points(v, 1), surface.points(v, 2));
  vtkNew<vtkCellArray> triangles;
  for (Index t = 0; t < surface.triangles.rows(); ++t)
    triangles->InsertNextCell(
        {surface.triangles(t, 0), surface.triangles(t, 1), surface.triangles(t, 2)});
  vtkNew<vtkDoubleArray> errors;
  errors->SetName("error_mm");
  for (const double error : error_mm) errors->InsertNextValue(error);
  vtkNew<vtkPolyData> data;
  data->SetPoints(points);
  data->SetPolys(triangles);
  data->GetPointData()->SetScalars(errors);
  return data;
}

void Look(const SurfaceMesh& surface, const CameraModel& from, ErrorMapView view,
          double width_to_height, vtkCamera* camera) {
  const Eigen::Matrix3d axes = from.camera_from_world.linear();
  const Vec3 up = -axes.row(1).transpose();
  const Vec3 along = view == ErrorMapView::FromCamera ? Vec3(axes.row(2).transpose())
                                                      : Vec3(-axes.row(0).transpose());
  const Vec3 right = along.cross(up);
  const auto middle_and_half = [&](const Vec3& axis, double* half) {
    const Eigen::VectorXd at = surface.points * axis;
    *half = 0.5 * (at.maxCoeff() - at.minCoeff());
    return 0.5 * (at.maxCoeff() + at.minCoeff());
  };
  double half_width = 0, half_height = 0, half_depth = 0;
  const double x = middle_and_half(right, &half_width), y = middle_and_half(up, &half_height),
               z = middle_and_half(along, &half_depth);
  const double scale =
      kMargin * std::max(half_height, half_width / (width_to_height * (1.0 - 2 * kScaleFraction)));
  const Vec3 focus = x * right + y * up + z * along;
  const double distance = 2 * half_depth + 2 * scale;
  const Vec3 eye = focus - distance * along;
  camera->ParallelProjectionOn();
  camera->SetFocalPoint(focus.x(), focus.y(), focus.z());
  camera->SetPosition(eye.x(), eye.y(), eye.z());
  camera->SetViewUp(up.x(), up.y(), up.z());
  camera->SetParallelScale(scale);
  camera->SetClippingRange(0.1 * distance, 2 * distance + 2 * half_depth);
}

Image PixelsOf(vtkRenderWindow* window, int width, int height) {
  vtkNew<vtkUnsignedCharArray> rgb;
  window->GetPixelData(0, 0, width - 1, height - 1, 0, rgb);
  Image image{width, height, 3, std::vector<std::uint8_t>(std::size_t(3) * width * height)};
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < 3; ++c)
        image.data[3 * (std::size_t(y) * width + x) + c] =
            rgb->GetValue(3 * ((vtkIdType(height) - 1 - y) * width + x) + 2 - c);
  return image;
}

}  // namespace

Image RenderErrorMap(const SurfaceMesh& surface, const Eigen::VectorXd& error_mm, double largest_mm,
                     const CameraModel& camera, ErrorMapView view, int width, int height) {
  if (surface.Empty() || error_mm.size() != surface.points.rows() || !(largest_mm > 0))
    throw std::invalid_argument("RenderErrorMap: one error a vertex and a scale are needed");
  std::string why_not;
  if (!RenderingAvailable(&why_not)) throw std::runtime_error(why_not);
  const vtkNew<vtkPolyData> data = Data(surface, error_mm);
  const vtkNew<vtkColorTransferFunction> colours = Colours(largest_mm);
  vtkNew<vtkPolyDataNormals> normals;
  normals->SetInputData(data);
  normals->SetFeatureAngle(kFeatureAngle_deg);
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputConnection(normals->GetOutputPort());
  mapper->SetLookupTable(colours);
  mapper->UseLookupTableScalarRangeOn();
  vtkNew<vtkActor> actor;
  actor->SetMapper(mapper);
  actor->GetProperty()->SetAmbient(0.35);
  actor->GetProperty()->SetDiffuse(0.65);
  vtkNew<vtkScalarBarActor> scale;
  scale->SetLookupTable(colours);
  scale->SetTitle("mm");
  scale->SetNumberOfLabels(6);
  scale->SetLabelFormat("%.0f");
  scale->SetPosition(1.0 - kScaleFraction, 0.1);
  scale->SetWidth(kScaleFraction - 0.02);
  scale->SetHeight(0.8);
  scale->UnconstrainedFontSizeOn();
  for (vtkTextProperty* text : {scale->GetTitleTextProperty(), scale->GetLabelTextProperty()}) {
    text->SetColor(0.95, 0.95, 0.95);
    text->SetFontSize(kText_px);
    text->ItalicOff();
    text->ShadowOff();
  }
  vtkNew<vtkRenderer> renderer;
  renderer->SetBackground(0.11, 0.14, 0.18);
  renderer->AddActor(actor);
  renderer->AddActor2D(scale);
  Look(surface, camera, view, double(width) / height, renderer->GetActiveCamera());
  vtkNew<vtkRenderWindow> window;
  window->SetOffScreenRendering(1);
  window->SetMultiSamples(0);
  window->SwapBuffersOff();
  window->SetSize(width, height);
  window->AddRenderer(renderer);
  window->Start();
  SurviveDisplayLoss(window->GetGenericDisplayId());
  window->Render();
  return PixelsOf(window, width, height);
}

}  // namespace kerf
