#include "Common/qKerfStyle.h"

#include <QPainter>
#include <QStyleFactory>
#include <QStyleOption>

#include "Common/qKerfTheme.h"

qKerfStyle::qKerfStyle() : QProxyStyle(QStyleFactory::create("Fusion")) {}

void qKerfStyle::drawPrimitive(PrimitiveElement element, const QStyleOption* option,
                               QPainter* painter, const QWidget* widget) const {
  if (element != PE_IndicatorCheckBox && element != PE_IndicatorItemViewItemCheck) {
    QProxyStyle::drawPrimitive(element, option, painter, widget);
    return;
  }
  const qKerfTheme& theme = qKerfTheme::Current();
  const bool enabled = option->state & State_Enabled, checked = option->state & State_On,
             partly = option->state & State_NoChange;
  const QColor ground = (checked || partly) && enabled ? theme.accent : theme.panel;
  const QColor mark = enabled ? theme.on_accent : theme.faint;
  const QRectF box = QRectF(option->rect).adjusted(1.5, 1.5, -1.5, -1.5);
  painter->save();
  painter->setRenderHint(QPainter::Antialiasing);
  painter->setPen(
      QPen(option->state & (State_MouseOver | State_HasFocus) ? theme.accent : theme.faint, 1.2));
  painter->setBrush(ground);
  painter->drawRoundedRect(box, 2.5, 2.5);
  painter->setPen(QPen(mark, 1.8, Qt::SolidLine, Qt::RoundCap, Qt::RoundJoin));
  const auto at = [&box](double x, double y) {
    return QPointF(box.left() + x * box.width(), box.top() + y * box.height());
  };
  if (partly) {
    painter->drawLine(at(0.25, 0.5), at(0.75, 0.5));
  } else if (checked) {
    painter->setBrush(Qt::NoBrush);
    painter->drawPolyline(QPolygonF() << at(0.22, 0.52) << at(0.42, 0.72) << at(0.78, 0.28));
  }
  painter->restore();
}
