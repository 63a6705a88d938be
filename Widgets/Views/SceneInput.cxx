#include "Views/SceneInput.h"

#include <vtkCamera.h>
#include <vtkRenderer.h>

#include <QKeyEvent>
#include <QMouseEvent>
#include <QWidget>

namespace {

constexpr double kTurn_deg = 10, kNearer = 1.15;
constexpr int kClick_px = 4;  ///< a press that moved less was a click

}  // namespace

SceneInput::SceneInput(QWidget* canvas, vtkRenderer* renderer, QObject* parent)
    : QObject(parent), canvas_(canvas), renderer_(renderer) {
  canvas->installEventFilter(this);
}

void SceneInput::SetPicking(bool picking) {
  picking_ = picking;
  dragging_ = false;
  canvas_->setCursor(picking ? Qt::CrossCursor : Qt::ArrowCursor);
}

QPointF SceneInput::WidgetFromWorld(const kerf::Vec3& world_mm) const {
  renderer_->SetWorldPoint(world_mm[0], world_mm[1], world_mm[2], 1);
  renderer_->WorldToDisplay();
  const double* p = renderer_->GetDisplayPoint();
  const double ratio = canvas_->devicePixelRatioF();
  return {p[0] / ratio, canvas_->height() - 1 - p[1] / ratio};
}

kerf::Vec3 SceneInput::RayAt(const QPoint& at, kerf::Vec3* origin_mm) const {
  const double ratio = canvas_->devicePixelRatioF();
  const double x = at.x() * ratio, y = (canvas_->height() - 1 - at.y()) * ratio;
  kerf::Vec3 ends[2];
  for (int e = 0; e < 2; ++e) {
    renderer_->SetDisplayPoint(x, y, e);
    renderer_->DisplayToWorld();
    const double* w = renderer_->GetWorldPoint();
    ends[e] = kerf::Vec3(w[0], w[1], w[2]) / w[3];
  }
  *origin_mm = ends[0];
  return (ends[1] - ends[0]).normalized();
}

bool SceneInput::MouseUsed(const QMouseEvent& event) {
  kerf::Vec3 origin_mm;
  if (event.type() == QEvent::MouseButtonPress && event.button() == Qt::LeftButton) {
    pressed_ = event.pos();
    dragging_ = false;  // where the last release was not seen
    emit Pressed(event.pos(), &dragging_);
    return dragging_;
  }
  const bool click = (event.pos() - pressed_).manhattanLength() < kClick_px;
  const bool over = event.type() == QEvent::MouseButtonRelease && event.button() == Qt::LeftButton;
  if (dragging_ && (over || event.type() == QEvent::MouseMove)) {
    if (over || !click) {
      const kerf::Vec3 direction = RayAt(click ? pressed_ : event.pos(), &origin_mm);
      emit Dragged(origin_mm, direction, over);
    }
    dragging_ = !over;
    return true;
  }
  if (over && click) {
    const kerf::Vec3 direction = RayAt(event.pos(), &origin_mm);
    emit Picked(origin_mm, direction);
  }
  return false;
}

void SceneInput::KeyPressed(QKeyEvent* event) {
  vtkCamera* camera = renderer_->GetActiveCamera();
  switch (event->key()) {
    case Qt::Key_Left:
    case Qt::Key_Right:
      camera->Azimuth(event->key() == Qt::Key_Left ? kTurn_deg : -kTurn_deg);
      break;
    case Qt::Key_Up:
    case Qt::Key_Down:
      camera->Elevation(event->key() == Qt::Key_Up ? kTurn_deg : -kTurn_deg);
      camera->OrthogonalizeViewUp();
      break;
    case Qt::Key_Plus:
    case Qt::Key_Equal:
      camera->Dolly(kNearer);
      break;
    case Qt::Key_Minus:
      camera->Dolly(1 / kNearer);
      break;
    case Qt::Key_Home:
      emit FitWanted();
      break;
    default:
      event->ignore();
      return;
  }
  event->accept();
  emit Turned();
}

bool SceneInput::eventFilter(QObject* watched, QEvent* event) {
  switch (event->type()) {
    case QEvent::KeyPress:
      // All of them: VTK's own letters (3 for glasses of two colours, w for wires) would be taken
      // for a fault. What is none of ours goes on to the page.
      KeyPressed(static_cast<QKeyEvent*>(event));
      return true;
    case QEvent::MouseButtonDblClick:
      if (picking_) break;
      emit WholePageWanted();
      return true;
    case QEvent::MouseButtonPress:
    case QEvent::MouseMove:
    case QEvent::MouseButtonRelease:
      if (picking_ && MouseUsed(*static_cast<QMouseEvent*>(event))) return true;
      break;
    default:
      break;
  }
  return QObject::eventFilter(watched, event);
}
