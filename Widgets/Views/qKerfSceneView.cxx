#include "Views/qKerfSceneView.h"

#include <QVTKOpenGLNativeWidget.h>
#include <vtkActor.h>
#include <vtkActor2D.h>
#include <vtkAnnotatedCubeActor.h>
#include <vtkCamera.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkContourFilter.h>
#include <vtkCoordinate.h>
#include <vtkDoubleArray.h>
#include <vtkGenericOpenGLRenderWindow.h>
#include <vtkGlyph3D.h>
#include <vtkInteractorStyleTrackballCamera.h>
#include <vtkLight.h>
#include <vtkLightKit.h>
#include <vtkLookupTable.h>
#include <vtkNew.h>
#include <vtkOrientationMarkerWidget.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkPolyDataNormals.h>
#include <vtkProperty.h>
#include <vtkRenderWindowInteractor.h>
#include <vtkRenderer.h>
#include <vtkScalarBarActor.h>
#include <vtkSphereSource.h>
#include <vtkTextActor.h>
#include <vtkTextProperty.h>

#include <QEvent>
#include <QMouseEvent>
#include <QTimer>
#include <QVBoxLayout>
#include <map>

#include "Adapters/Vtk/Conversions.h"
#include "Common/qKerfTheme.h"

struct qKerfSceneView::Impl {
  QVTKOpenGLNativeWidget* widget = nullptr;
  vtkNew<vtkGenericOpenGLRenderWindow> window;
  vtkNew<vtkRenderer> renderer;
  vtkNew<vtkLookupTable> table;
  vtkNew<vtkScalarBarActor> bar;
  vtkNew<vtkAnnotatedCubeActor> cube;
  vtkNew<vtkOrientationMarkerWidget> marker;
  vtkNew<vtkLightKit> lights;
  std::map<std::string, std::vector<vtkSmartPointer<vtkProp>>> props;
  std::string with_bar;
  bool picking = false, waiting = false, framed = false;
  QPoint pressed;

  void Add(const std::string& name, vtkProp* prop) {
    props[name].push_back(prop);
    renderer->AddViewProp(prop);
  }
};

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

}  // namespace

qKerfSceneView::qKerfSceneView(QWidget* parent) : QWidget(parent), impl_(new Impl) {
  setObjectName("sceneView");
  setMinimumSize(160, 130);
  impl_->window->SetMultiSamples(0);
  impl_->widget = new QVTKOpenGLNativeWidget(impl_->window, this);
  impl_->widget->setObjectName("sceneCanvas");
  impl_->window->AddRenderer(impl_->renderer);
  auto* column = new QVBoxLayout(this);
  column->setContentsMargins(0, 0, 0, 0);
  column->addWidget(impl_->widget);
  impl_->widget->installEventFilter(this);
  vtkNew<vtkInteractorStyleTrackballCamera> style;
  impl_->window->GetInteractor()->SetInteractorStyle(style);
  impl_->renderer->AutomaticLightCreationOff();
  impl_->lights->AddLightsToRenderer(impl_->renderer);

  // Red where it is near, blue where it is far, through colours of rising brightness.
  const double stops[5][3] = {
      {0.75, 0.1, 0.15}, {0.95, 0.5, 0.2}, {0.95, 0.85, 0.4}, {0.45, 0.75, 0.75}, {0.2, 0.4, 0.8}};
  impl_->table->SetNumberOfTableValues(256);
  for (int i = 0; i < 256; ++i) {
    const double t = i / 255.0 * 4;
    const int s = std::min(3, static_cast<int>(t));
    double rgb[3];
    for (int c = 0; c < 3; ++c) rgb[c] = stops[s][c] + (stops[s + 1][c] - stops[s][c]) * (t - s);
    impl_->table->SetTableValue(i, rgb[0], rgb[1], rgb[2], 1);
  }
  impl_->bar->SetLookupTable(impl_->table);
  impl_->bar->SetNumberOfLabels(5);
  impl_->bar->SetLabelFormat("%.0f");
  impl_->bar->SetMaximumWidthInPixels(60);
  impl_->bar->SetPosition(0.86, 0.2);
  impl_->bar->SetWidth(0.12);
  impl_->bar->SetHeight(0.6);
  impl_->bar->UnconstrainedFontSizeOn();
  impl_->bar->SetVisibility(false);
  impl_->renderer->AddActor2D(impl_->bar);

  impl_->cube->SetXPlusFaceText("L");
  impl_->cube->SetXMinusFaceText("R");
  impl_->cube->SetYPlusFaceText("P");
  impl_->cube->SetYMinusFaceText("A");
  impl_->cube->SetZPlusFaceText("S");
  impl_->cube->SetZMinusFaceText("I");
  impl_->cube->SetFaceTextScale(0.6);
  impl_->cube->SetZFaceTextRotation(-90);  // upright with anterior up
  impl_->marker->SetOrientationMarker(impl_->cube);
  impl_->marker->SetInteractor(impl_->window->GetInteractor());
  impl_->marker->SetViewport(0.0, 0.0, 0.16, 0.2);
  impl_->marker->SetEnabled(1);
  impl_->marker->InteractiveOff();
  ApplyTheme();
  LookFrom('A');
}

qKerfSceneView::~qKerfSceneView() { impl_->marker->SetEnabled(0); }

void qKerfSceneView::ApplyTheme() {
  const qKerfTheme& t = qKerfTheme::Current();
  impl_->renderer->SetBackground(t.view.redF(), t.view.greenF(), t.view.blueF());
  impl_->renderer->SetBackground2(t.view_top.redF(), t.view_top.greenF(), t.view_top.blueF());
  impl_->renderer->GradientBackgroundOn();
  for (vtkTextProperty* p :
       {impl_->bar->GetLabelTextProperty(), impl_->bar->GetTitleTextProperty()}) {
    p->SetColor(t.text.redF(), t.text.greenF(), t.text.blueF());
    p->SetFontSize(12);
    p->ItalicOff();
    p->ShadowOff();
    p->BoldOff();
  }
  impl_->cube->GetCubeProperty()->SetColor(t.raised.redF(), t.raised.greenF(), t.raised.blueF());
  impl_->cube->GetTextEdgesProperty()->SetColor(t.text.redF(), t.text.greenF(), t.text.blueF());
  for (vtkProperty* letter :
       {impl_->cube->GetXPlusFaceProperty(), impl_->cube->GetXMinusFaceProperty(),
        impl_->cube->GetYPlusFaceProperty(), impl_->cube->GetYMinusFaceProperty(),
        impl_->cube->GetZPlusFaceProperty(), impl_->cube->GetZMinusFaceProperty()})
    letter->SetColor(t.text.redF(), t.text.greenF(), t.text.blueF());
  Render();
}

void qKerfSceneView::Render() {
  // Several changes in one turn of the event loop are drawn once.
  if (impl_->waiting) return;
  impl_->waiting = true;
  QTimer::singleShot(0, this, [this] {
    impl_->waiting = false;
    if (!impl_->framed && !impl_->props.empty()) {
      impl_->framed = true;
      impl_->renderer->ResetCamera();
    }
    impl_->renderer->ResetCameraClippingRange();
    if (isVisible()) impl_->window->Render();
  });
}

void qKerfSceneView::SetSurface(const std::string& name, const kerf::SurfaceMesh& surface,
                                const QColor& color, double opacity) {
  Remove(name);
  if (surface.Empty()) return;
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputData(Shaded(kerf::ToVtk(surface)));
  mapper->ScalarVisibilityOff();
  vtkNew<vtkActor> actor;
  actor->SetMapper(mapper);
  Paint(actor->GetProperty(), color, opacity);
  impl_->Add(name, actor);
  Render();
}

void qKerfSceneView::SetColoredSurface(const std::string& name, const kerf::SurfaceMesh& surface,
                                       const std::vector<double>& values, double low, double high,
                                       const QString& title, double opacity) {
  Remove(name);
  if (surface.Empty()) return;
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
  mapper->SetLookupTable(impl_->table);
  mapper->UseLookupTableScalarRangeOn();
  impl_->table->SetTableRange(low, high);
  vtkNew<vtkActor> actor;
  actor->SetMapper(mapper);
  actor->GetProperty()->SetOpacity(opacity);
  impl_->Add(name, actor);
  impl_->bar->SetTitle(title.toUtf8().constData());
  impl_->bar->SetVisibility(true);
  impl_->with_bar = name;
  Render();
}

void qKerfSceneView::SetLine(const std::string& name, const kerf::Points& points,
                             const QColor& color, double width_px) {
  Remove(name);
  if (points.rows() < 2) return;
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputData(PointSet(points, true));
  // In front of the surface that it lies on.
  mapper->SetResolveCoincidentTopologyToPolygonOffset();
  mapper->SetRelativeCoincidentTopologyLineOffsetParameters(0, -8);
  vtkNew<vtkActor> actor;
  actor->SetMapper(mapper);
  Paint(actor->GetProperty(), color, 1);
  actor->GetProperty()->SetLineWidth(static_cast<float>(width_px));
  actor->GetProperty()->LightingOff();
  impl_->Add(name, actor);
  Render();
}

void qKerfSceneView::SetPoints(const std::string& name, const kerf::Points& points,
                               const std::vector<std::string>& labels, const QColor& color,
                               double radius_mm) {
  Remove(name);
  if (points.rows() == 0) return;
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
  impl_->Add(name, actor);
  for (std::size_t i = 0; i < labels.size() && i < std::size_t(points.rows()); ++i) {
    vtkNew<vtkTextActor> text;
    text->SetInput(labels[i].c_str());
    text->GetPositionCoordinate()->SetCoordinateSystemToWorld();
    text->SetPosition(0, 0);
    text->GetPositionCoordinate()->SetValue(points(i, 0), points(i, 1), points(i, 2));
    text->GetTextProperty()->SetFontSize(14);
    text->GetTextProperty()->SetColor(1, 1, 1);
    text->GetTextProperty()->SetBackgroundColor(0, 0, 0);
    text->GetTextProperty()->SetBackgroundOpacity(0.55);
    impl_->Add(name, text);
  }
  Render();
}

void qKerfSceneView::SetIsoline(const std::string& name, const kerf::SurfaceMesh& surface,
                                const std::vector<double>& values, double value,
                                const QColor& color) {
  Remove(name);
  if (surface.Empty() || values.size() != static_cast<std::size_t>(surface.points.rows())) return;
  auto data = kerf::ToVtk(surface);
  data->GetPointData()->SetScalars(ArrayOf(values));
  vtkNew<vtkContourFilter> contour;
  contour->SetInputData(data);
  contour->SetValue(0, value);
  contour->ComputeNormalsOff();
  contour->Update();
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputData(contour->GetOutput());
  mapper->ScalarVisibilityOff();
  mapper->SetResolveCoincidentTopologyToPolygonOffset();
  mapper->SetRelativeCoincidentTopologyLineOffsetParameters(0, -8);
  vtkNew<vtkActor> actor;
  actor->SetMapper(mapper);
  Paint(actor->GetProperty(), color, 1);
  actor->GetProperty()->SetLineWidth(3);
  actor->GetProperty()->LightingOff();
  impl_->Add(name, actor);
  Render();
}

void qKerfSceneView::Remove(const std::string& name) {
  const auto found = impl_->props.find(name);
  if (found == impl_->props.end()) return;
  for (const auto& prop : found->second) impl_->renderer->RemoveViewProp(prop);
  impl_->props.erase(found);
  if (impl_->with_bar == name) {
    impl_->bar->SetVisibility(false);
    impl_->with_bar.clear();
  }
  Render();
}

void qKerfSceneView::SetOpacity(const std::string& name, double opacity) {
  const auto found = impl_->props.find(name);
  if (found == impl_->props.end()) return;
  for (const auto& prop : found->second)
    if (auto* actor = vtkActor::SafeDownCast(prop)) actor->GetProperty()->SetOpacity(opacity);
  Render();
}

void qKerfSceneView::Clear() {
  while (!impl_->props.empty()) Remove(std::string(impl_->props.begin()->first));
  impl_->framed = false;
}

int qKerfSceneView::Count() const { return static_cast<int>(impl_->props.size()); }

void qKerfSceneView::SetPicking(bool picking) {
  impl_->picking = picking;
  impl_->widget->setCursor(picking ? Qt::CrossCursor : Qt::ArrowCursor);
}

void qKerfSceneView::LookFrom(char from) {
  double eye[3] = {0, 0, 0}, up[3] = {0, 0, 1};
  switch (from) {
    case 'L':
      eye[0] = 1;
      break;
    case 'R':
      eye[0] = -1;
      break;
    case 'P':
      eye[1] = 1;
      break;
    case 'S':
      eye[2] = 1;
      up[1] = -1;
      up[2] = 0;
      break;
    case 'I':
      eye[2] = -1;
      up[1] = -1;
      up[2] = 0;
      break;
    default:
      eye[1] = -1;
  }
  vtkCamera* camera = impl_->renderer->GetActiveCamera();
  camera->SetFocalPoint(0, 0, 0);
  camera->SetPosition(eye);
  camera->SetViewUp(up);
  impl_->renderer->ResetCamera();
  Render();
}

void qKerfSceneView::ResetCamera() {
  impl_->renderer->ResetCamera();
  Render();
}

kerf::Vec3 qKerfSceneView::ViewDirection() const {
  double d[3];
  impl_->renderer->GetActiveCamera()->GetDirectionOfProjection(d);
  return {d[0], d[1], d[2]};
}

QPointF qKerfSceneView::WidgetFromWorld(const kerf::Vec3& world_mm) const {
  impl_->renderer->SetWorldPoint(world_mm[0], world_mm[1], world_mm[2], 1);
  impl_->renderer->WorldToDisplay();
  const double* p = impl_->renderer->GetDisplayPoint();
  const double ratio = impl_->widget->devicePixelRatioF();
  return {p[0] / ratio, impl_->widget->height() - 1 - p[1] / ratio};
}

QImage qKerfSceneView::Picture() { return impl_->widget->grabFramebuffer(); }

bool qKerfSceneView::eventFilter(QObject* watched, QEvent* event) {
  if (event->type() == QEvent::MouseButtonDblClick && !impl_->picking) {
    emit WholePageWanted();
    return true;
  }
  if (!impl_->picking) return QWidget::eventFilter(watched, event);
  auto* mouse = static_cast<QMouseEvent*>(event);
  if (event->type() == QEvent::MouseButtonPress && mouse->button() == Qt::LeftButton)
    impl_->pressed = mouse->pos();
  if (event->type() == QEvent::MouseButtonRelease && mouse->button() == Qt::LeftButton &&
      (mouse->pos() - impl_->pressed).manhattanLength() < 4) {
    const double ratio = impl_->widget->devicePixelRatioF();
    const double x = mouse->pos().x() * ratio,
                 y = (impl_->widget->height() - 1 - mouse->pos().y()) * ratio;
    kerf::Vec3 ends[2];
    for (int e = 0; e < 2; ++e) {
      impl_->renderer->SetDisplayPoint(x, y, e);
      impl_->renderer->DisplayToWorld();
      const double* w = impl_->renderer->GetWorldPoint();
      ends[e] = kerf::Vec3(w[0], w[1], w[2]) / w[3];
    }
    emit Picked(ends[0], (ends[1] - ends[0]).normalized());
  }
  return QWidget::eventFilter(watched, event);
}
