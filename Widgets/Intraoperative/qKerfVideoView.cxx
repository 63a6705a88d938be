#include "Intraoperative/qKerfVideoView.h"

#include <QMouseEvent>
#include <QPainter>
#include <QWheelEvent>

qKerfVideoView::qKerfVideoView(QWidget* parent) : QWidget(parent) {
  setMinimumSize(320, 180);
  setSizePolicy(QSizePolicy::Expanding, QSizePolicy::Expanding);
  setAttribute(Qt::WA_OpaquePaintEvent);
}

void qKerfVideoView::SetPicture(const kerf::Image& picture) {
  const QSize size(picture.width, picture.height);
  // The only format that Qt scales fast.
  if (picture_.size() != size || !picture_.isDetached())
    picture_ = QImage(size, QImage::Format_RGB32);
  const int blue = 0, green = picture.channels == 3 ? 1 : 0, red = picture.channels == 3 ? 2 : 0;
  for (int y = 0; y < picture.height; ++y) {
    auto* out = reinterpret_cast<QRgb*>(picture_.scanLine(y));
    const std::uint8_t* in =
        picture.data.data() + std::size_t(y) * picture.width * picture.channels;
    for (int x = 0; x < picture.width; ++x, in += picture.channels)
      out[x] = qRgb(in[red], in[green], in[blue]);
  }
  update();
}

void qKerfVideoView::SetMarkers(const QVector<Marker>& markers) {
  markers_ = markers;
  update();
}

void qKerfVideoView::SetStroke(const QPolygonF& stroke) {
  stroke_ = stroke;
  update();
}

void qKerfVideoView::SetBanner(const QString& text, const QColor& ground) {
  if (banner_ == text && banner_ground_ == ground) return;
  banner_ = text;
  banner_ground_ = ground;
  update();
}

QRectF qKerfVideoView::Place() const {
  if (picture_.isNull()) return rect();
  const QSizeF size = QSizeF(picture_.size()).scaled(this->size(), Qt::KeepAspectRatio);
  return {(width() - size.width()) / 2, (height() - size.height()) / 2, size.width(),
          size.height()};
}

QPointF qKerfVideoView::ToPixel(const QPointF& widget) const {
  const QRectF place = Place();
  if (picture_.isNull() || place.width() <= 0) return {};
  const double scale = picture_.width() / place.width();
  return (widget - place.topLeft()) * scale - QPointF(0.5, 0.5);
}

QPointF qKerfVideoView::ToWidget(const QPointF& pixel) const {
  const QRectF place = Place();
  if (picture_.isNull()) return {};
  const double scale = place.width() / picture_.width();
  return place.topLeft() + (pixel + QPointF(0.5, 0.5)) * scale;
}

void qKerfVideoView::paintEvent(QPaintEvent*) {
  QPainter painter(this);
  painter.fillRect(rect(), Qt::black);
  if (picture_.isNull()) {
    painter.setPen(Qt::lightGray);
    painter.drawText(rect(), Qt::AlignCenter, tr("No picture"));
  } else {
    const QRectF place = Place();
    painter.setRenderHint(QPainter::SmoothPixmapTransform, place.size() != picture_.size());
    painter.drawImage(place, picture_);
  }
  painter.setRenderHint(QPainter::Antialiasing);
  QFont font = painter.font();
  font.setPointSize(13);
  font.setBold(true);
  painter.setFont(font);
  for (const Marker& marker : markers_) {
    const QPointF at = ToWidget(marker.at);
    for (const auto& [color, width] :
         {qMakePair(QColor(0, 0, 0), 5.0), qMakePair(marker.color, 2.5)}) {
      painter.setPen(QPen(color, width));
      painter.drawEllipse(at, 8, 8);
      painter.drawLine(at - QPointF(12, 0), at + QPointF(12, 0));
      painter.drawLine(at - QPointF(0, 12), at + QPointF(0, 12));
      if (marker.crossed) painter.drawLine(at - QPointF(12, 12), at + QPointF(12, 12));
    }
    const QRectF box(at + QPointF(12, -26),
                     QSizeF(painter.fontMetrics().horizontalAdvance(marker.text) + 10, 22));
    painter.fillRect(box, QColor(0, 0, 0, 150));
    painter.setPen(marker.color);
    painter.drawText(box, Qt::AlignCenter, marker.text);
  }
  if (stroke_.size() > 1) {
    QPolygonF line;
    for (const QPointF& p : stroke_) line << ToWidget(p);
    painter.setPen(QPen(Qt::black, 6, Qt::SolidLine, Qt::RoundCap));
    painter.drawPolyline(line);
    painter.setPen(QPen(QColor(255, 240, 90), 3, Qt::DashLine, Qt::RoundCap));
    painter.drawPolyline(line);
  }
  if (!banner_.isEmpty()) {
    int points = qBound(12, height() / 22, 30);
    for (; points > 9; --points) {  // beside another view there may be little room
      font.setPointSize(points);
      if (QFontMetrics(font).horizontalAdvance(banner_) <= width() - 16) break;
    }
    font.setPointSize(points);
    painter.setFont(font);
    const QRectF line(0, height() - 2.0 * font.pointSize() - 12, width(),
                      2.0 * font.pointSize() + 12);
    painter.fillRect(line, banner_ground_);
    painter.setPen(Qt::white);
    painter.drawText(line, Qt::AlignCenter, banner_);
  }
}

void qKerfVideoView::mousePressEvent(QMouseEvent* event) {
  last_ = ToPixel(event->localPos());
  emit Pressed(last_, event->button());
}

void qKerfVideoView::mouseMoveEvent(QMouseEvent* event) {
  const QPointF now = ToPixel(event->localPos());
  if (event->buttons() != Qt::NoButton)
    emit Dragged(last_, now, event->buttons(), event->modifiers());
  last_ = now;
}

void qKerfVideoView::mouseReleaseEvent(QMouseEvent* event) {
  emit Released(ToPixel(event->localPos()), event->button());
}

void qKerfVideoView::wheelEvent(QWheelEvent* event) {
  emit Turned(event->angleDelta().y() / 120.0);
  event->accept();
}
