#pragma once

#include <QWidget>

#include "Session/PlanningSession.h"

class QLabel;
class QLineEdit;
class QPushButton;

/// Step 6: the checklist and the case folder.
class qKerfSavePanel : public QWidget {
  Q_OBJECT
 public:
  explicit qKerfSavePanel(QWidget* parent = nullptr);
  void Show(const kerf::PlanningSession& session);
  QString Folder() const;
  void SetFolder(const QString& folder);

 signals:
  void SaveWanted(const QString& folder);
  void ContinueWanted();

 private:
  QLabel *list_, *saved_;
  QLineEdit* folder_;
  QPushButton *save_, *go_on_;
  bool can_save_ = false;
};
