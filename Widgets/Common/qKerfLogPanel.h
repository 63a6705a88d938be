#pragma once

#include <QPlainTextEdit>

/// What happened, newest last; at most 5000 lines are kept.
class qKerfLogPanel : public QPlainTextEdit {
  Q_OBJECT
 public:
  enum Level { Info, Warning, Problem };
  explicit qKerfLogPanel(QWidget* parent = nullptr);
  void Add(Level level, const QString& text);
};
