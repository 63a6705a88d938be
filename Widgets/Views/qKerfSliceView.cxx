#include "Views/qKerfSliceView.h"

#include <QKeyEvent>
#include <QMouseEvent>
#include <QPainter>
#include <QWheelEvent>
#include <algorithm>
#include <cmath>

#include "Common/qKerfTheme.h"

namespace {

const char* NameOf(kerf::SlicePlane plane) {
  switch (plane) {
    case kerf::SlicePlane::Axial:
      return "Axial";
    case kerf::SlicePlane::Coronal:
      return "Coronal";
    default:
      return "Sagittal";
  }
}

QColor ColorOf(kerf::SlicePlane plane) {
  switch (plane) {
    case kerf::SlicePlane::Axial:
      return QColor("#e5484d");
    case kerf::SlicePlane::Coronal:
      return QColor("#46a758");
    default:
      return QColor("#e2b714");
  }
}

/// White with a dark rim: legible on every grey.
void DrawText(QPainter& painter, const QPointF& at, const QString& text) {
  painter.setPen(QColor(0, 0, 0, 200));
  for (const QPointF& d : {QPointF(1, 1), QPointF(-1, 1), QPointF(1, -1), QPointF(-1, -1)})
    painter.drawText(at + d, text);
  painter.setPen(Qt::white);
  painter.drawText(at, text);
}

}  // namespace

qKerfSliceView::qKerfSliceView(kerf::SlicePlane plane, QWidget* parent)
    : QWidget(parent), plane_(plane) {
  setObjectName(QStringLiteral("slice%1").arg(NameOf(plane)));
  setFocusPolicy(Qt::StrongFocus);
  setMouseTracking(true);
  setAttribute(Qt::WA_OpaquePaintEvent);
  setMinimumSize(160, 130);
  mask_colors_.fill(0);
}

void qKerfSliceView::SetSources(const kerf::Volume* ct, const kerf::LabelMap* labels) {
  ct_ = ct;
  labels_ = labels;
  if (HasImage()) {
    frame_ = kerf::MakeSliceFrame(ct_->grid, plane_);
    const kerf::Vec3 middle = 0.5 * (ct_->grid.size.cast<double>() - kerf::Vec3::Ones());
    crosshair_mm_ = ct_->grid.WorldFromIndex(middle);
    slice_ = frame_.slices / 2;
  }
  FitToWindow();
}

void qKerfSliceView::SetMask(const kerf::LabelMap* mask, const QColor& color) {
  mask_ = mask;
  mask_colors_[1] = color.rgba();
  Refresh();
}

void qKerfSliceView::SetLabelColors(const std::array<std::uint32_t, 256>& colors) {
  colors_ = colors;
  Refresh();
}

void qKerfSliceView::SetFill(double fill) {
  fill_ = fill;
  Refresh();
}

void qKerfSliceView::SetWindowLevel(double window_hu, double level_hu) {
  window_hu_ = window_hu;
  level_hu_ = level_hu;
  Refresh();
}

void qKerfSliceView::SetCrosshair(const kerf::Vec3& position_mm) {
  crosshair_mm_ = position_mm;
  if (!HasImage()) return;
  const kerf::Vec3 pixel = frame_.PixelOf(ct_->grid.IndexFromWorld(position_mm));
  const int slice =
      std::clamp(static_cast<int>(std::lround(pixel[2])), 0, std::max(0, frame_.slices - 1));
  if (slice != slice_) {
    slice_ = slice;
    stale_ = true;
  }
  update();
}

void qKerfSliceView::SetMarkers(const QVector<Marker>& markers) {
  markers_ = markers;
  update();
}

void qKerfSliceView::SetTool(bool active, double brush_radius_mm) {
  tool_ = active;
  brush_mm_ = brush_radius_mm;
  setCursor(active ? Qt::CrossCursor : Qt::ArrowCursor);
  update();
}

void qKerfSliceView::Refresh() {
  stale_ = true;
  update();
}

void qKerfSliceView::FitToWindow() {
  zoom_ = 1;
  pan_ = {};
  Refresh();
}

void qKerfSliceView::SetSlice(int slice) {
  if (!HasImage()) return;
  slice = std::clamp(slice, 0, frame_.slices - 1);
  if (slice == slice_) return;
  kerf::Vec3 index = ct_->grid.IndexFromWorld(crosshair_mm_);
  index[frame_.n_axis] = slice;
  SetCrosshair(ct_->grid.WorldFromIndex(index));
  emit CrosshairMoved(crosshair_mm_);
}

double qKerfSliceView::Scale() const {
  const double w = frame_.columns * frame_.spacing_u_mm, h = frame_.rows * frame_.spacing_v_mm;
  if (w <= 0 || h <= 0) return 1;
  return zoom_ * std::min(width() / w, height() / h);
}

QRectF qKerfSliceView::ImageRect() const {
  const double w = frame_.columns * frame_.spacing_u_mm * Scale(),
               h = frame_.rows * frame_.spacing_v_mm * Scale();
  return {0.5 * (width() - w) + pan_.x(), 0.5 * (height() - h) + pan_.y(), w, h};
}

kerf::Vec3 qKerfSliceView::IndexAt(const QPointF& widget) const {
  const QRectF rect = ImageRect();
  return frame_.IndexOf((widget.x() - rect.left()) / rect.width() * frame_.columns - 0.5,
                        (widget.y() - rect.top()) / rect.height() * frame_.rows - 0.5, slice_);
}

QPointF qKerfSliceView::WidgetFromWorld(const kerf::Vec3& world_mm) const {
  if (!HasImage()) return {};
  const kerf::Vec3 pixel = frame_.PixelOf(ct_->grid.IndexFromWorld(world_mm));
  const QRectF rect = ImageRect();
  return {rect.left() + (pixel[0] + 0.5) / frame_.columns * rect.width(),
          rect.top() + (pixel[1] + 0.5) / frame_.rows * rect.height()};
}

kerf::Vec3 qKerfSliceView::WorldAt(const QPointF& widget) const {
  kerf::Vec3 index = IndexAt(widget);
  for (int a = 0; a < 3; ++a) index[a] = std::clamp(index[a], 0.0, ct_->grid.size[a] - 1.0);
  return ct_->grid.WorldFromIndex(index);
}

void qKerfSliceView::RenderImage() {
  kerf::RenderSlice(*ct_, frame_, slice_, window_hu_, level_hu_, &pixels_);
  if (labels_ && labels_->voxels && labels_->grid.size == ct_->grid.size)
    kerf::BlendLabels(*labels_, frame_, slice_, colors_, fill_, &pixels_);
  if (mask_ && mask_->voxels && mask_->grid.size == ct_->grid.size)
    kerf::BlendLabels(*mask_, frame_, slice_, mask_colors_, 0.0, &pixels_);
  stale_ = false;
}

void qKerfSliceView::paintEvent(QPaintEvent*) {
  QPainter painter(this);
  painter.fillRect(rect(), Qt::black);
  if (!HasImage()) {
    painter.setPen(QColor("#9aa5b1"));
    painter.drawText(rect(), Qt::AlignCenter, tr(NameOf(plane_)));
    return;
  }
  if (stale_) RenderImage();
  const QImage image(reinterpret_cast<const uchar*>(pixels_.data()), frame_.columns, frame_.rows,
                     frame_.columns * 4, QImage::Format_RGB32);
  painter.setRenderHint(QPainter::SmoothPixmapTransform);
  painter.drawImage(ImageRect(), image);
  PaintOverlay(painter);
}

void qKerfSliceView::PaintOverlay(QPainter& painter) {
  const QPointF cross = WidgetFromWorld(crosshair_mm_);
  painter.setPen(QPen(QColor(255, 255, 255, 110), 1));
  const double gap = 12;
  painter.drawLine(QPointF(0, cross.y()), QPointF(cross.x() - gap, cross.y()));
  painter.drawLine(QPointF(cross.x() + gap, cross.y()), QPointF(width(), cross.y()));
  painter.drawLine(QPointF(cross.x(), 0), QPointF(cross.x(), cross.y() - gap));
  painter.drawLine(QPointF(cross.x(), cross.y() + gap), QPointF(cross.x(), height()));

  painter.setRenderHint(QPainter::Antialiasing);
  for (const Marker& marker : markers_) {
    const kerf::Vec3 pixel = frame_.PixelOf(ct_->grid.IndexFromWorld(marker.position_mm));
    const double off_mm = std::abs(pixel[2] - slice_) * frame_.spacing_n_mm;
    if (off_mm > 12) continue;
    const QPointF at = WidgetFromWorld(marker.position_mm);
    QColor color = marker.color;
    color.setAlphaF(off_mm < 1 ? 1.0 : 0.45);
    painter.setPen(QPen(Qt::black, 1));
    painter.setBrush(color);
    const double r = off_mm < 1 ? 5 : 3.5;
    painter.drawEllipse(at, r, r);
    if (off_mm < 1) DrawText(painter, at + QPointF(8, 4), marker.text);
  }
  painter.setBrush(Qt::NoBrush);
  if (tool_ && brush_mm_ > 0 && hover_.x() >= 0) {
    painter.setPen(QPen(qKerfTheme::Current().accent, 1.5));
    painter.drawEllipse(hover_, brush_mm_ * Scale(), brush_mm_ * Scale());
  }

  QFont font = painter.font();
  font.setPointSizeF(9);
  painter.setFont(font);
  const QFontMetrics metrics(font);
  const int middle = height() / 2 + metrics.ascent() / 2, h = metrics.height();
  DrawText(painter, QPointF(6, middle), QString::fromStdString(frame_.left));
  DrawText(painter, QPointF(width() - 16, middle), QString::fromStdString(frame_.right));
  DrawText(painter, QPointF(width() / 2 - 4, h), QString::fromStdString(frame_.top));
  DrawText(painter, QPointF(width() / 2 - 4, height() - 6), QString::fromStdString(frame_.bottom));
  const QString where =
      QStringLiteral("%1  %2 / %3").arg(tr(NameOf(plane_))).arg(slice_ + 1).arg(frame_.slices);
  DrawText(painter, QPointF(6, h), where);
  DrawText(painter, QPointF(6, height() - 6),
           QStringLiteral("W %1  L %2").arg(std::lround(window_hu_)).arg(std::lround(level_hu_)));
  painter.setPen(QPen(ColorOf(plane_), hasFocus() ? 3 : 2));
  painter.drawLine(0, 0, width(), 0);
}

void qKerfSliceView::MoveCrosshair(const QPointF& widget) {
  crosshair_mm_ = WorldAt(widget);
  update();
  emit CrosshairMoved(crosshair_mm_);
}

void qKerfSliceView::StepCrosshair(int right, int down) {
  if (!HasImage()) return;
  kerf::Vec3 pixel = frame_.PixelOf(ct_->grid.IndexFromWorld(crosshair_mm_));
  pixel[0] = std::clamp(pixel[0] + right, 0.0, frame_.columns - 1.0);
  pixel[1] = std::clamp(pixel[1] + down, 0.0, frame_.rows - 1.0);
  crosshair_mm_ = ct_->grid.WorldFromIndex(frame_.IndexOf(pixel[0], pixel[1], pixel[2]));
  update();
  emit CrosshairMoved(crosshair_mm_);
}

void qKerfSliceView::UseToolAtCrosshair() {
  if (!HasImage()) return;
  if (!tool_) {
    emit SpotChosen(crosshair_mm_);
    return;
  }
  emit ToolPressed(ct_->grid.IndexFromWorld(crosshair_mm_));
  emit ToolReleased();
}

void qKerfSliceView::Zoom(int steps) {
  zoom_ = std::clamp(zoom_ * std::pow(1.15, steps), 0.5, 20.0);
  update();
}

void qKerfSliceView::mousePressEvent(QMouseEvent* event) {
  last_ = event->localPos();
  if (!HasImage() || event->button() != Qt::LeftButton) return;
  if (tool_) {
    tool_down_ = true;
    emit ToolPressed(IndexAt(last_));
  } else {
    MoveCrosshair(last_);
  }
}

void qKerfSliceView::mouseMoveEvent(QMouseEvent* event) {
  if (!HasImage()) return;
  const QPointF now = event->localPos(), moved = now - last_;
  hover_ = now;
  if (event->buttons() & Qt::LeftButton) {
    if (tool_down_)
      emit ToolMoved(IndexAt(now));
    else if (!tool_)
      MoveCrosshair(now);
  } else if (event->buttons() & Qt::MiddleButton) {
    pan_ += moved;
  } else if (event->buttons() & Qt::RightButton) {
    window_hu_ = std::max(1.0, window_hu_ + 2.0 * moved.x());
    level_hu_ -= 1.5 * moved.y();
    Refresh();
    emit WindowLevelChanged(window_hu_, level_hu_);
  }
  last_ = now;
  if (tool_ || event->buttons()) update();
}

void qKerfSliceView::mouseReleaseEvent(QMouseEvent* event) {
  if (event->button() == Qt::LeftButton && tool_down_) {
    tool_down_ = false;
    emit ToolReleased();
  }
}

void qKerfSliceView::mouseDoubleClickEvent(QMouseEvent* event) {
  if (event->button() == Qt::LeftButton && !tool_) emit WholePageWanted();
}

void qKerfSliceView::wheelEvent(QWheelEvent* event) {
  const int steps = event->angleDelta().y() / 120;
  const int direction = steps != 0 ? steps : (event->angleDelta().y() > 0 ? 1 : -1);
  if (event->modifiers() & Qt::ControlModifier) {
    Zoom(direction);
  } else {
    SetSlice(slice_ + direction);
  }
  event->accept();
}

void qKerfSliceView::keyPressEvent(QKeyEvent* event) {
  const int key = event->key();
  if (event->modifiers() & Qt::ControlModifier && key >= Qt::Key_Left && key <= Qt::Key_Down) {
    const int by = event->modifiers() & Qt::ShiftModifier ? 10 : 1;
    StepCrosshair(by * ((key == Qt::Key_Right) - (key == Qt::Key_Left)),
                  by * ((key == Qt::Key_Down) - (key == Qt::Key_Up)));
    return;
  }
  switch (key) {
    case Qt::Key_Up:
      SetSlice(slice_ + 1);
      break;
    case Qt::Key_Down:
      SetSlice(slice_ - 1);
      break;
    case Qt::Key_PageUp:
      SetSlice(slice_ + 10);
      break;
    case Qt::Key_PageDown:
      SetSlice(slice_ - 10);
      break;
    case Qt::Key_Plus:
    case Qt::Key_Equal:
      Zoom(1);
      break;
    case Qt::Key_Minus:
      Zoom(-1);
      break;
    case Qt::Key_Space:
      UseToolAtCrosshair();
      break;
    case Qt::Key_Home:
      FitToWindow();
      break;
    default:
      QWidget::keyPressEvent(event);
  }
}

void qKerfSliceView::leaveEvent(QEvent*) {
  hover_ = {-1, -1};
  update();
}
