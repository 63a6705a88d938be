#pragma once

#include <QImage>
#include <QVector>
#include <QWidget>
#include <array>

#include "Session/PlanningSlice.h"

/// One slice of a CT with label outlines, crosshair, orientation letters and markers.
/// Wheel, arrow and page keys scroll; Ctrl+wheel, + and − zoom; the middle button moves; the right
/// button sets window (left–right) and level (up–down); the left button and Ctrl+arrows move the
/// crosshair (with Shift by ten); with a tool the left button, or Space at the crosshair, is handed
/// on; a double click asks for the whole page.
class qKerfSliceView : public QWidget {
  Q_OBJECT
 public:
  struct Marker {
    kerf::Vec3 position_mm;
    QColor color;
    QString text;
  };

  explicit qKerfSliceView(kerf::SlicePlane plane, QWidget* parent = nullptr);

  /// The view keeps the pointers; both change only on the GUI thread, and Refresh is called after.
  void SetSources(const kerf::Volume* ct, const kerf::LabelMap* labels);
  /// A second label map, drawn as outline in one colour (margin); null = none.
  void SetMask(const kerf::LabelMap* mask, const QColor& color);
  void SetLabelColors(const std::array<std::uint32_t, 256>& colors);
  void SetFill(double fill);
  void SetWindowLevel(double window_hu, double level_hu);
  void SetCrosshair(const kerf::Vec3& position_mm);
  void SetMarkers(const QVector<Marker>& markers);
  /// With a tool the left button paints or picks. A brush is shown as a circle.
  void SetTool(bool active, double brush_radius_mm);
  void Refresh();
  void FitToWindow();

  const kerf::SliceFrame& Frame() const { return frame_; }
  int Slice() const { return slice_; }
  void SetSlice(int slice);
  /// Where a world point is shown, in widget pixels (whatever slice it lies on).
  QPointF WidgetFromWorld(const kerf::Vec3& world_mm) const;
  /// Voxel index under a widget pixel in the shown slice.
  kerf::Vec3 IndexAt(const QPointF& widget) const;

 signals:
  void CrosshairMoved(const kerf::Vec3& position_mm);
  void WindowLevelChanged(double window_hu, double level_hu);
  void ToolPressed(const kerf::Vec3& index);
  void ToolMoved(const kerf::Vec3& index);
  void ToolReleased();
  /// Space without a tool: the crosshair's place is meant.
  void SpotChosen(const kerf::Vec3& position_mm);
  void WholePageWanted();

 protected:
  void paintEvent(QPaintEvent* event) override;
  void mousePressEvent(QMouseEvent* event) override;
  void mouseMoveEvent(QMouseEvent* event) override;
  void mouseReleaseEvent(QMouseEvent* event) override;
  void mouseDoubleClickEvent(QMouseEvent* event) override;
  void wheelEvent(QWheelEvent* event) override;
  void keyPressEvent(QKeyEvent* event) override;
  void leaveEvent(QEvent* event) override;
  QSize sizeHint() const override { return {360, 300}; }

 private:
  bool HasImage() const { return ct_ && ct_->voxels; }
  double Scale() const;  ///< widget pixels per mm
  QRectF ImageRect() const;
  kerf::Vec3 WorldAt(const QPointF& widget) const;
  void MoveCrosshair(const QPointF& widget);
  /// By pixels of the slice, to the right and down.
  void StepCrosshair(int right, int down);
  void UseToolAtCrosshair();
  void Zoom(int steps);
  void RenderImage();
  void PaintOverlay(QPainter& painter);

  kerf::SlicePlane plane_;
  const kerf::Volume* ct_ = nullptr;
  const kerf::LabelMap* labels_ = nullptr;
  const kerf::LabelMap* mask_ = nullptr;
  std::array<std::uint32_t, 256> colors_{}, mask_colors_{};
  kerf::SliceFrame frame_;
  kerf::Vec3 crosshair_mm_ = kerf::Vec3::Zero();
  int slice_ = 0;
  double window_hu_ = 400, level_hu_ = 40, fill_ = 0.25, zoom_ = 1, brush_mm_ = 0;
  QPointF pan_, last_, hover_{-1, -1};
  bool tool_ = false, tool_down_ = false, stale_ = true;
  QVector<Marker> markers_;
  std::vector<std::uint32_t> pixels_;
};
