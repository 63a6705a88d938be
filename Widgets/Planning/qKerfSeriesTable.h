#pragma once

#include <QVector>
#include <QWidget>

class QPushButton;
class QTreeWidget;

/// The series of a DICOM folder, for the person who chooses among them.
class qKerfSeriesTable : public QWidget {
  Q_OBJECT
 public:
  struct Series {
    QString uid, description, modality, patient, laterality, phase, spacing;
    int slices = 0;
  };
  explicit qKerfSeriesTable(QWidget* parent = nullptr);
  /// Hidden where there are none.
  void SetSeries(const QString& folder, const QVector<Series>& series);

 signals:
  void Chosen(const QString& folder, const QString& uid);

 private:
  QTreeWidget* series_;
  QString folder_;
};
