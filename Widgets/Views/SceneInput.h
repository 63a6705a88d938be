#pragma once

#include <QObject>
#include <QPointF>

#include "Core/Types.h"

class QKeyEvent;
class QMouseEvent;
class QWidget;
class vtkRenderer;

/// Keys and clicks in a 3-D view. Arrows turn it, + and − go nearer and away, Home shows
/// everything. While picking, a click that is no drag asks for a place on the organ, and what the
/// view's owner takes on a press is moved by the drag; other drags turn the view as always.
class SceneInput : public QObject {
  Q_OBJECT
 public:
  /// Filters the events of `canvas`; both outlive this.
  SceneInput(QWidget* canvas, vtkRenderer* renderer, QObject* parent);
  void SetPicking(bool picking);
  /// Widget pixel of a world point.
  QPointF WidgetFromWorld(const kerf::Vec3& world_mm) const;

 signals:
  void Picked(const kerf::Vec3& origin_mm, const kerf::Vec3& direction);
  /// A press while picking. @param taken set by who wants the drag
  void Pressed(const QPointF& at, bool* taken);
  /// The drag of what was taken goes on. @param over it ends here
  void Dragged(const kerf::Vec3& origin_mm, const kerf::Vec3& direction, bool over);
  void WholePageWanted();
  void FitWanted();
  void Turned();

 protected:
  bool eventFilter(QObject* watched, QEvent* event) override;

 private:
  bool MouseUsed(const QMouseEvent& event);
  void KeyPressed(QKeyEvent* event);
  /// From the eye's side through a pixel. @return unit direction
  kerf::Vec3 RayAt(const QPoint& at, kerf::Vec3* origin_mm) const;

  QWidget* canvas_;
  vtkRenderer* renderer_;
  bool picking_ = false, dragging_ = false;
  QPoint pressed_;
};
