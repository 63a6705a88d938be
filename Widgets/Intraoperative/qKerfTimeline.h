#pragma once

#include <QSlider>
#include <vector>

#include "Pipelines/SessionPlayback.h"

/// A session's time as a bar: what can be looked at already, what happened when, where one is. A
/// click or a drag goes there.
class qKerfTimeline : public QSlider {
  Q_OBJECT
 public:
  explicit qKerfTimeline(QWidget* parent = nullptr);

  /// @param frames of the session
  void SetSession(int frames, const std::vector<kerf::PlaybackEvent>& events);
  void SetReady(int frames);
  /// Widget coordinate of a frame, px.
  int PlaceOf(int frame) const;
  QSize sizeHint() const override { return {400, 34}; }

 signals:
  void Wanted(int frame);

 protected:
  void paintEvent(QPaintEvent* event) override;
  void mousePressEvent(QMouseEvent* event) override;
  void mouseMoveEvent(QMouseEvent* event) override;
  void mouseReleaseEvent(QMouseEvent*) override {}
  bool event(QEvent* event) override;

 private:
  int FrameAt(int x) const;
  std::vector<kerf::PlaybackEvent> events_;
  int ready_ = 0;
};
