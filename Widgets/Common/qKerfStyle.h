#pragma once

#include <QProxyStyle>

/// Fusion with boxes to tick that are seen on dark ground, too.
class qKerfStyle : public QProxyStyle {
 public:
  qKerfStyle();
  void drawPrimitive(PrimitiveElement element, const QStyleOption* option, QPainter* painter,
                     const QWidget* widget) const override;
};
