#pragma once

#include <QVector>
#include <QWidget>

#include "Session/PlanningSession.h"

class QButtonGroup;
class QLabel;
class QToolButton;

/// The steps of planning with their state; the sentence under the current one says what to do next.
class qKerfStepList : public QWidget {
  Q_OBJECT
 public:
  explicit qKerfStepList(QWidget* parent = nullptr);
  void Show(const kerf::PlanningSession& session);
  int Current() const { return current_; }

 public slots:
  void SetCurrent(int step);

 signals:
  void StepChosen(int step);

 private:
  QButtonGroup* group_;
  QVector<QToolButton*> buttons_;
  QLabel* sentence_;
  int current_ = 0;
  QStringList sentences_;
};
