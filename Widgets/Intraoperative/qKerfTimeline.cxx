#include "Intraoperative/qKerfTimeline.h"

#include <QHelpEvent>
#include <QMouseEvent>
#include <QPainter>
#include <QToolTip>

namespace {

using Kind = kerf::PlaybackEvent::Kind;
constexpr int kRim_px = 8, kNear_px = 4;

QColor ColorOf(Kind kind) {
  switch (kind) {
    case Kind::Cut:
      return {255, 214, 60};
    case Kind::Decision:
      return {110, 190, 255};
    case Kind::Mark:
      return {240, 240, 240};
    case Kind::Loss:
      return {255, 90, 80};
  }
  return {};
}

}  // namespace

qKerfTimeline::qKerfTimeline(QWidget* parent) : QSlider(Qt::Horizontal, parent) {
  setObjectName("timeline");
  setFocusPolicy(Qt::NoFocus);
  setFixedHeight(34);
  setRange(0, 0);
}

void qKerfTimeline::SetSession(int frames, const std::vector<kerf::PlaybackEvent>& events) {
  events_ = events;
  ready_ = 0;
  setRange(0, qMax(0, frames - 1));
  setValue(0);
  update();
}

void qKerfTimeline::SetReady(int frames) {
  if (ready_ == frames) return;
  ready_ = frames;
  update();
}

int qKerfTimeline::PlaceOf(int frame) const {
  const int room = width() - 2 * kRim_px;
  return kRim_px + (maximum() > 0 ? static_cast<int>(double(frame) * room / maximum() + 0.5) : 0);
}

int qKerfTimeline::FrameAt(int x) const {
  const int room = qMax(1, width() - 2 * kRim_px);
  return qBound(0, static_cast<int>(double(x - kRim_px) * maximum() / room + 0.5), maximum());
}

void qKerfTimeline::paintEvent(QPaintEvent*) {
  QPainter painter(this);
  painter.setRenderHint(QPainter::Antialiasing);
  const QRect bar(kRim_px, height() / 2 - 4, width() - 2 * kRim_px, 8);
  painter.fillRect(bar, QColor(90, 96, 104));
  QRect done = bar;
  done.setRight(PlaceOf(qMax(0, ready_ - 1)));
  if (ready_ > 0) painter.fillRect(done, QColor(70, 140, 95));
  for (const kerf::PlaybackEvent& event : events_) {
    const int x = PlaceOf(event.frame);
    const QRect tick(x - 2, 3, 4, height() - 6);
    painter.fillRect(tick.adjusted(-1, -1, 1, 1), QColor(20, 22, 26));
    painter.fillRect(tick, ColorOf(event.kind));
  }
  painter.setPen(QPen(QColor(20, 22, 26), 1.5));
  painter.setBrush(Qt::white);
  painter.drawEllipse(QPointF(PlaceOf(value()), height() / 2.0), 7, 7);
}

void qKerfTimeline::mousePressEvent(QMouseEvent* event) {
  if (event->button() == Qt::LeftButton) emit Wanted(FrameAt(event->x()));
}

void qKerfTimeline::mouseMoveEvent(QMouseEvent* event) {
  if (event->buttons() & Qt::LeftButton) emit Wanted(FrameAt(event->x()));
}

bool qKerfTimeline::event(QEvent* event) {
  if (event->type() != QEvent::ToolTip) return QSlider::event(event);
  const auto* help = static_cast<QHelpEvent*>(event);
  QString text;
  for (const kerf::PlaybackEvent& happened : events_)
    if (qAbs(PlaceOf(happened.frame) - help->x()) <= kNear_px)
      text += (text.isEmpty() ? "" : "\n") + QString::number(happened.time_s, 'f', 2) + " s  " +
              QString::fromStdString(happened.words);
  QToolTip::showText(help->globalPos(), text, this);
  return true;
}
