#pragma once

#include <QWidget>
#include <vector>

#include "Pipelines/IntraoperativeDesk.h"

class QComboBox;
class QLabel;
class QLineEdit;
class QListWidget;
class QPushButton;

/// Step 1: the right case, the right camera file, pictures.
class qKerfCheckInPanel : public QWidget {
  Q_OBJECT
 public:
  explicit qKerfCheckInPanel(QWidget* parent = nullptr);

  QString Confirmed() const;
  void SetCase(const QString& folder, const QString& pseudonym);
  void SetCamera(const QString& file);
  void SetSource(const QString& path);
  void SetItems(const std::vector<kerf::CheckInItem>& items, bool may_go_on);
  /// @param sessions unfinished ones, newest first; empty hides the offer
  void OfferResume(const std::vector<std::string>& sessions);
  /// @param sessions that can be played, newest first; empty hides the offer
  void OfferRecorded(const std::vector<std::string>& sessions);

 signals:
  void SourceWanted(const QString& path);
  void CameraWanted(const QString& file);
  void ConfirmedChanged();
  void GoOn();
  void ResumeWanted(const QString& session);
  void PlayWanted(const QString& session);

 private:
  QLabel* case_;
  QLineEdit *confirmed_, *source_, *camera_;
  QListWidget* items_;
  QPushButton *go_on_, *resume_, *play_;
  QComboBox* recorded_;
  QString resume_session_;
  std::vector<kerf::CheckInItem> shown_;
};
