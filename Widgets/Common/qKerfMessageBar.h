#pragma once

#include <QFrame>
#include <QString>

class QLabel;

/// One sentence above the page: what happened and what to do. Stays until it is closed or replaced;
/// asks nothing, stops nothing.
class qKerfMessageBar : public QFrame {
  Q_OBJECT
 public:
  enum Level { Info, Warning, Problem };
  explicit qKerfMessageBar(QWidget* parent = nullptr);
  void Show(Level level, const QString& text);
  QString Text() const;

 public slots:
  void Close();

 private:
  QLabel* mark_;
  QLabel* text_;
};
