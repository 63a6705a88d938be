#include "Common/qKerfIcons.h"

#include <QGuiApplication>
#include <QIconEngine>
#include <QPainter>
#include <QPainterPath>
#include <QPalette>
#include <QtMath>

namespace {

// Shapes on a field of 24 × 24. M, L, C as in SVG; O x y r is a circle.
struct Shape {
  const char* name;
  const char* path;
};
const Shape kShapes[] = {
    {"cases", "M 3 7 L 3 19 L 21 19 L 21 8 L 12 8 L 10 5 L 3 5 L 3 7"},
    {"planning", "O 12 12 8 M 12 4 L 12 20 M 4 12 L 20 12 O 15 9 2"},
    {"surgery", "M 3 6 L 15 6 L 15 18 L 3 18 L 3 6 M 15 10 L 21 7 L 21 17 L 15 14 M 7 15 L 11 9"},
    {"settings", "M 4 7 L 20 7 M 4 12 L 20 12 M 4 17 L 20 17 O 9 7 2 O 15 12 2 O 7 17 2"},
    {"log", "M 5 5 L 19 5 M 5 9 L 19 9 M 5 13 L 19 13 M 5 17 L 13 17"},
    {"brush", "M 20 4 L 11 13 M 9 13 C 12 13 12 17 9 19 C 7 20 5 20 4 20 C 6 18 5 14 9 13"},
    {"eraser", "M 9 19 L 4 14 L 14 4 L 20 10 L 11 19 L 9 19 M 9 9 L 15 15 M 11 19 L 20 19"},
    {"sphere", "O 12 12 8 M 4 12 C 8 15 16 15 20 12"},
    {"threshold", "M 4 20 L 20 20 M 4 20 C 8 20 8 6 11 6 C 14 6 14 20 20 20 M 14 4 L 14 20"},
    {"grow", "O 12 12 3 M 12 7 L 12 3 M 12 17 L 12 21 M 7 12 L 3 12 M 17 12 L 21 12"},
    {"contour", "M 5 12 C 4 4 15 3 18 8 C 22 13 16 21 10 19 C 6 18 5 15 5 12"},
    {"islands", "O 9 10 6 O 18 18 2 O 19 6 2"},
    {"smooth", "M 3 15 C 7 3 9 3 12 12 C 14 19 17 19 21 8"},
    {"boolean", "O 9 12 6 O 15 12 6"},
    {"cursor", "M 12 3 L 12 21 M 3 12 L 21 12 O 12 12 3"},
    {"window", "O 12 12 8 M 12 4 L 12 20 M 14 7 L 18 7 M 14 11 L 20 11 M 14 15 L 19 15"},
    {"seed", "O 12 9 5 M 12 14 L 12 21 M 12 7 L 12 11 M 10 9 L 14 9"},
    {"line", "M 4 18 C 8 6 14 20 20 6 O 4 18 1.5 O 20 6 1.5"},
    {"landmark", "M 12 21 C 5 13 6 4 12 4 C 18 4 19 13 12 21 O 12 10 2"},
    {"eye", "M 3 12 C 8 5 16 5 21 12 C 16 19 8 19 3 12 O 12 12 3"},
    {"play", "M 7 4 L 19 12 L 7 20 L 7 4"},
    {"stop", "M 6 6 L 18 6 L 18 18 L 6 18 L 6 6"},
};

QPainterPath PathOf(const QString& name) {
  QPainterPath path;
  const Shape* found = nullptr;
  for (const Shape& s : kShapes)
    if (name == QLatin1String(s.name)) found = &s;
  const QStringList words = QString(found ? found->path : "O 12 12 2").split(' ');
  const auto number = [&words](int i) { return words[i].toDouble(); };
  for (int i = 0; i < words.size();) {
    const QChar op = words[i][0];
    if (op == 'M') path.moveTo(number(i + 1), number(i + 2)), i += 3;
    if (op == 'L') path.lineTo(number(i + 1), number(i + 2)), i += 3;
    if (op == 'O') {
      path.addEllipse(QPointF(number(i + 1), number(i + 2)), number(i + 3), number(i + 3));
      i += 4;
    }
    if (op == 'C') {
      path.cubicTo(number(i + 1), number(i + 2), number(i + 3), number(i + 4), number(i + 5),
                   number(i + 6));
      i += 7;
    }
  }
  return path;
}

class Engine : public QIconEngine {
 public:
  explicit Engine(const QString& name) : name_(name), path_(PathOf(name)) {}
  void paint(QPainter* painter, const QRect& rect, QIcon::Mode mode, QIcon::State state) override {
    const QPalette palette = QGuiApplication::palette();
    QColor color =
        palette.color(mode == QIcon::Disabled ? QPalette::Disabled : QPalette::Active,
                      state == QIcon::On ? QPalette::HighlightedText : QPalette::WindowText);
    painter->save();
    painter->setRenderHint(QPainter::Antialiasing);
    painter->translate(rect.topLeft());
    painter->scale(rect.width() / 24.0, rect.height() / 24.0);
    painter->setPen(QPen(color, 1.8, Qt::SolidLine, Qt::RoundCap, Qt::RoundJoin));
    painter->drawPath(path_);
    painter->restore();
  }
  QPixmap pixmap(const QSize& size, QIcon::Mode mode, QIcon::State state) override {
    QPixmap pixmap(size);
    pixmap.fill(Qt::transparent);
    QPainter painter(&pixmap);
    paint(&painter, QRect(QPoint(), size), mode, state);
    return pixmap;
  }
  QIconEngine* clone() const override { return new Engine(name_); }

 private:
  QString name_;
  QPainterPath path_;
};

}  // namespace

QIcon qKerfIcon(const QString& name) { return QIcon(new Engine(name)); }
