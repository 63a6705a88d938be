#pragma once

#include <QStringList>
#include <QWidget>

#include "Session/PlanningSession.h"

class QLabel;
class QPushButton;
class QTreeWidget;

/// Step 1: opens a CT; lists the series of a DICOM folder; says what was read and what is odd.
class qKerfImportPanel : public QWidget {
  Q_OBJECT
 public:
  struct Series {
    QString uid, description, modality, spacing;
    int slices = 0;
  };
  explicit qKerfImportPanel(QWidget* parent = nullptr);
  void Show(const kerf::PlanningSession& session);
  /// A folder with several series: the user has to choose. Empty hides the list.
  void SetSeries(const QString& folder, const QVector<Series>& series);

 signals:
  /// @param series empty = the only one
  void OpenWanted(const QString& path, const QString& series);

 private:
  QTreeWidget* series_;
  QLabel *series_hint_, *info_, *warnings_;
  QPushButton* open_series_;
  QString folder_;
};
