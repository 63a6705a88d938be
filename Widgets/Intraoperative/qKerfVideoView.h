#pragma once

#include <QColor>
#include <QImage>
#include <QPolygonF>
#include <QString>
#include <QVector>
#include <QWidget>

#include "Core/Frame.h"

/// Shows pictures as large as they fit and tells where in the picture the mouse is. Coordinates are
/// raw image pixels, centres at integers. GUI thread.
class qKerfVideoView : public QWidget {
  Q_OBJECT
 public:
  struct Marker {
    QPointF at;  ///< px
    QString text;
    QColor color;
    bool crossed = false;  ///< left out
  };

  explicit qKerfVideoView(QWidget* parent = nullptr);

  void SetPicture(const kerf::Image& picture);
  void SetMarkers(const QVector<Marker>& markers);
  /// A stroke in the making. @param of empty: none
  void SetStroke(const QPolygonF& stroke);
  /// One large line over the picture ("RAW VIDEO"); empty: none.
  void SetBanner(const QString& text, const QColor& ground = QColor(0, 0, 0, 170));

  const QImage& Picture() const { return picture_; }
  QPointF ToPixel(const QPointF& widget) const;
  QPointF ToWidget(const QPointF& pixel) const;
  QSize sizeHint() const override { return {960, 540}; }

 signals:
  void Pressed(const QPointF& pixel, Qt::MouseButton button);
  void Dragged(const QPointF& from, const QPointF& to, Qt::MouseButtons buttons,
               Qt::KeyboardModifiers modifiers);
  void Released(const QPointF& pixel, Qt::MouseButton button);
  void Turned(double wheel_steps);

 protected:
  void paintEvent(QPaintEvent* event) override;
  void mousePressEvent(QMouseEvent* event) override;
  void mouseMoveEvent(QMouseEvent* event) override;
  void mouseReleaseEvent(QMouseEvent* event) override;
  void wheelEvent(QWheelEvent* event) override;

 private:
  QRectF Place() const;

  QImage picture_;
  QVector<Marker> markers_;
  QPolygonF stroke_;
  QString banner_;
  QColor banner_ground_;
  QPointF last_;
};
