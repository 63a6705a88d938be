#pragma once

#include <QDialog>
#include <QVector>
#include <map>

class QComboBox;

/// What do the values of a foreign label map mean? (TotalSegmentator numbers a hundred organs.)
class qKerfLabelImportDialog : public QDialog {
  Q_OBJECT
 public:
  struct Row {
    int value = 0;
    QString name;  ///< from the file, may be empty
    double volume_ml = 0;
  };
  explicit qKerfLabelImportDialog(const QVector<Row>& rows, QWidget* parent = nullptr);
  /// Value in the file → 0 (leave out), 1 organ, 2 tumour, 3 inner structure.
  std::map<int, int> Roles() const;

 private:
  QVector<Row> rows_;
  QVector<QComboBox*> roles_;
};
