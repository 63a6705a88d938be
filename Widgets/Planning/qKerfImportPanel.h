#pragma once

#include <QWidget>

#include "Session/PlanningSession.h"

class QLabel;

/// Step 1: opens a CT; says what was read and what is odd.
class qKerfImportPanel : public QWidget {
  Q_OBJECT
 public:
  explicit qKerfImportPanel(QWidget* parent = nullptr);
  void Show(const kerf::PlanningSession& session);
  /// The folder holds several series, which stand in a table beside.
  void SetChoosing(bool choosing);

 signals:
  /// @param series empty = the only one
  void OpenWanted(const QString& path, const QString& series);

 private:
  QLabel *series_hint_, *info_, *warnings_;
};
