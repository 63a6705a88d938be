#pragma once

#include <QWidget>

#include "Pipelines/SessionPlayback.h"

class QComboBox;
class QLabel;
class QListWidget;
class QPushButton;

/// A recorded session: play, and what happened in it.
class qKerfReviewPanel : public QWidget {
  Q_OBJECT
 public:
  explicit qKerfReviewPanel(QWidget* parent = nullptr);

  void SetSession(const kerf::SessionPlayback& playback);
  /// Where one is, and how far the session has been done again.
  void SetPlace(const kerf::SessionPlayback& playback, int frame);
  void SetPlaying(bool playing);
  double Speed() const;

 signals:
  void PlayToggled(bool play);
  void FrameWanted(int frame);
  void StepWanted(int frames);

 private:
  QLabel *title_, *place_, *state_;
  QPushButton* play_;
  QComboBox* speed_;
  QListWidget* events_;
};
