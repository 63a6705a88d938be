#pragma once

#include <QWidget>

#include "Session/PlanningSession.h"

class QLabel;
class QListWidget;
class QPushButton;

/// Step 5: calibration of the laparoscope, landmarks on the organ.
class qKerfCameraPanel : public QWidget {
  Q_OBJECT
 public:
  explicit qKerfCameraPanel(QWidget* parent = nullptr);
  void Show(const kerf::PlanningSession& session);
  bool IsPlacing() const;
  void StopPlacing();

 signals:
  void CameraWanted(const QString& path);
  void PlacingToggled(bool placing);
  void RenameWanted(int index, const QString& name);
  void RemoveWanted(int index);
  void ReadLandmarksWanted(const QString& path);

 private:
  QLabel* camera_;
  QListWidget* list_;
  QPushButton *place_, *remove_;
};
