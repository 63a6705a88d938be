#include "Views/qKerfSceneView.h"

#include <QVTKOpenGLNativeWidget.h>
#include <vtkActor.h>
#include <vtkActor2D.h>
#include <vtkAnnotatedCubeActor.h>
#include <vtkBoundingBox.h>
#include <vtkCamera.h>
#include <vtkGenericOpenGLRenderWindow.h>
#include <vtkInteractorStyleTrackballCamera.h>
#include <vtkLightKit.h>
#include <vtkLookupTable.h>
#include <vtkNew.h>
#include <vtkOrientationMarkerWidget.h>
#include <vtkProperty.h>
#include <vtkRenderWindowInteractor.h>
#include <vtkRenderer.h>
#include <vtkScalarBarActor.h>
#include <vtkTextActor.h>
#include <vtkTextProperty.h>

#include <QTimer>
#include <QVBoxLayout>
#include <algorithm>
#include <deque>
#include <map>
#include <set>

#include "Common/qKerfTheme.h"
#include "Views/SceneInput.h"
#include "Views/SceneProps.h"

struct qKerfSceneView::Impl {
  QVTKOpenGLNativeWidget* widget = nullptr;
  vtkNew<vtkGenericOpenGLRenderWindow> window;
  vtkNew<vtkRenderer> renderer;
  vtkNew<vtkLookupTable> table;
  vtkNew<vtkScalarBarActor> bar;
  vtkNew<vtkTextActor> hint;  ///< while nothing is shown
  vtkNew<vtkAnnotatedCubeActor> cube;
  vtkNew<vtkOrientationMarkerWidget> marker;
  vtkNew<vtkLightKit> lights;
  std::map<std::string, std::vector<vtkSmartPointer<vtkProp>>> props;
  std::string with_bar;
  SceneInput* input = nullptr;
  bool waiting = false, framed = false;
  int furniture = 0;  ///< shown so far of: the hint, the cube
  bool bar_drawn = false;
  std::set<std::string> drawn;     ///< names that were drawn once
  std::deque<std::string> unseen;  ///< names that wait for it

  void Add(const std::string& name, vtkProp* prop) {
    props[name].push_back(prop);
    renderer->AddViewProp(prop);
    if (drawn.count(name)) return;
    prop->SetVisibility(false);
    if (std::find(unseen.begin(), unseen.end(), name) == unseen.end()) unseen.push_back(name);
  }

  /// The camera as far away as everything needs, also what waits to be drawn.
  void Frame() {
    vtkBoundingBox box;
    for (const auto& [name, parts] : props)
      for (const auto& prop : parts)
        if (const double* bounds = prop->GetBounds()) box.AddBounds(bounds);
    if (!box.IsValid()) return;
    double bounds[6];
    box.GetBounds(bounds);
    renderer->ResetCamera(bounds);
  }

  /// The first picture of a kind of thing compiles its shaders on the window's thread, 20 to 40 ms
  /// each when drawing in software. So a picture shows one thing more than the picture before.
  /// @return whether more is waiting
  bool ShowOneMore() {
    if (furniture < 2) {
      if (++furniture == 2) {
        marker->SetEnabled(1);
        marker->InteractiveOff();
      }
    } else if (!unseen.empty()) {
      for (const auto& prop : props[unseen.front()]) prop->SetVisibility(true);
      drawn.insert(unseen.front());
      unseen.pop_front();
    } else {
      bar_drawn = bar_drawn || !with_bar.empty();
    }
    hint->SetVisibility(props.empty());
    bar->SetVisibility(bar_drawn && !with_bar.empty());
    return furniture < 2 || !unseen.empty() || (!bar_drawn && !with_bar.empty());
  }
};

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
  impl_->widget->setAcceptDrops(false);  // files are for the window
  impl_->input = new SceneInput(impl_->widget, impl_->renderer, this);
  connect(impl_->input, &SceneInput::Picked, this, &qKerfSceneView::Picked);
  connect(impl_->input, &SceneInput::Pressed, this, &qKerfSceneView::Pressed);
  connect(impl_->input, &SceneInput::Dragged, this, &qKerfSceneView::Dragged);
  connect(impl_->input, &SceneInput::WholePageWanted, this, &qKerfSceneView::WholePageWanted);
  connect(impl_->input, &SceneInput::FitWanted, this, &qKerfSceneView::ResetCamera);
  connect(impl_->input, &SceneInput::Turned, this, &qKerfSceneView::Render);
  impl_->widget->hide();
  vtkNew<vtkInteractorStyleTrackballCamera> style;
  impl_->window->GetInteractor()->SetInteractorStyle(style);
  impl_->renderer->AutomaticLightCreationOff();
  impl_->lights->AddLightsToRenderer(impl_->renderer);

  kerf_scene::FillNearToFar(impl_->table);
  impl_->bar->SetLookupTable(impl_->table);
  impl_->bar->SetNumberOfLabels(5);
  impl_->bar->SetLabelFormat("%.0f");
  impl_->bar->SetMaximumWidthInPixels(60);
  impl_->bar->SetPosition(0.86, 0.2);
  impl_->bar->SetWidth(0.12);
  impl_->bar->SetHeight(0.6);
  impl_->bar->UnconstrainedFontSizeOn();
  impl_->bar->SetVerticalTitleSeparation(8);
  impl_->bar->SetVisibility(false);
  impl_->hint->SetVisibility(false);
  impl_->renderer->AddActor2D(impl_->bar);

  impl_->hint->GetTextProperty()->SetJustificationToCentered();
  impl_->hint->GetTextProperty()->SetVerticalJustificationToCentered();
  impl_->hint->GetTextProperty()->SetFontSize(15);
  impl_->hint->GetPositionCoordinate()->SetCoordinateSystemToNormalizedViewport();
  impl_->hint->SetPosition(0.5, 0.5);
  impl_->renderer->AddActor2D(impl_->hint);

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
  ApplyTheme();
  LookFrom('A');
}

qKerfSceneView::~qKerfSceneView() { impl_->marker->SetEnabled(0); }

void qKerfSceneView::SetHint(const QString& text) {
  impl_->hint->SetInput(text.toUtf8().constData());
  Render();
}

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
  impl_->hint->GetTextProperty()->SetColor(t.faint.redF(), t.faint.greenF(), t.faint.blueF());
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
      impl_->Frame();
    }
    if (!isVisible()) return;
    const bool more = impl_->ShowOneMore();
    impl_->renderer->ResetCameraClippingRange();
    impl_->window->Render();
    if (more) Render();
  });
}

void qKerfSceneView::showEvent(QShowEvent* event) {
  QWidget::showEvent(event);
  // OpenGL starts in a turn of its own, after the page's first picture.
  QTimer::singleShot(0, impl_->widget, [this] {
    impl_->widget->show();
    Render();
  });
}

void qKerfSceneView::SetSurface(const std::string& name, const kerf::SurfaceMesh& surface,
                                const QColor& color, double opacity) {
  Remove(name);
  if (surface.Empty()) return;
  impl_->Add(name, kerf_scene::SurfaceProp(surface, color, opacity));
  Render();
}

void qKerfSceneView::SetColoredSurface(const std::string& name, const kerf::SurfaceMesh& surface,
                                       const std::vector<double>& values, double low, double high,
                                       const QString& title, double opacity) {
  Remove(name);
  if (surface.Empty()) return;
  impl_->table->SetTableRange(low, high);
  impl_->Add(name, kerf_scene::ColoredSurfaceProp(surface, values, impl_->table, opacity));
  impl_->bar->SetTitle(title.toUtf8().constData());
  impl_->with_bar = name;
  Render();
}

void qKerfSceneView::SetLine(const std::string& name, const kerf::Points& points,
                             const QColor& color, double width_px) {
  Remove(name);
  if (points.rows() < 2) return;
  impl_->Add(name, kerf_scene::LineProp(points, color, width_px));
  Render();
}

void qKerfSceneView::SetPoints(const std::string& name, const kerf::Points& points,
                               const std::vector<std::string>& labels, const QColor& color,
                               double radius_mm) {
  Remove(name);
  if (points.rows() == 0) return;
  impl_->Add(name, kerf_scene::BallsProp(points, color, radius_mm));
  for (std::size_t i = 0; i < labels.size() && i < std::size_t(points.rows()); ++i)
    impl_->Add(name, kerf_scene::NameProp(labels[i], points.row(i).transpose()));
  Render();
}

void qKerfSceneView::SetIsoline(const std::string& name, const kerf::SurfaceMesh& surface,
                                const std::vector<double>& values, double value,
                                const QColor& color) {
  Remove(name);
  if (surface.Empty() || values.size() != static_cast<std::size_t>(surface.points.rows())) return;
  impl_->Add(name, kerf_scene::IsolineProp(surface, values, value, color));
  Render();
}

void qKerfSceneView::Remove(const std::string& name) {
  const auto found = impl_->props.find(name);
  if (found == impl_->props.end()) return;
  for (const auto& prop : found->second) impl_->renderer->RemoveViewProp(prop);
  impl_->props.erase(found);
  impl_->unseen.erase(std::remove(impl_->unseen.begin(), impl_->unseen.end(), name),
                      impl_->unseen.end());
  if (impl_->with_bar == name) impl_->with_bar.clear();
  Render();
}

void qKerfSceneView::Clear() {
  while (!impl_->props.empty()) Remove(std::string(impl_->props.begin()->first));
  impl_->framed = false;
}

int qKerfSceneView::Count() const { return static_cast<int>(impl_->props.size()); }

void qKerfSceneView::SetPicking(bool picking) { impl_->input->SetPicking(picking); }

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
  impl_->Frame();
  Render();
}

void qKerfSceneView::ResetCamera() {
  impl_->Frame();
  Render();
}

kerf::Vec3 qKerfSceneView::ViewDirection() const {
  double d[3];
  impl_->renderer->GetActiveCamera()->GetDirectionOfProjection(d);
  return {d[0], d[1], d[2]};
}

QPointF qKerfSceneView::WidgetFromWorld(const kerf::Vec3& world_mm) const {
  return impl_->input->WidgetFromWorld(world_mm);
}

QImage qKerfSceneView::Picture() {
  while (impl_->ShowOneMore()) {
  }
  return impl_->widget->grabFramebuffer();
}
