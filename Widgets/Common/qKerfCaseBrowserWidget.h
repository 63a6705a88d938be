#pragma once

#include <QStringList>
#include <QWidget>

class QLabel;
class QListWidget;
class QPushButton;

/// Recent cases with picture, pseudonym and state; open one, open another folder, start a new one.
class qKerfCaseBrowserWidget : public QWidget {
  Q_OBJECT
 public:
  explicit qKerfCaseBrowserWidget(QWidget* parent = nullptr);
  /// Case folders, newest first; their state is read anew.
  void SetCases(const QStringList& folders);

 signals:
  void CaseChosen(const QString& folder);
  void NewCaseWanted();
  void ForgetWanted(const QString& folder);

 private:
  void ChooseFolder();
  QString Selected() const;

  QListWidget* list_;
  QLabel* empty_;
  QPushButton *open_, *forget_;
};
