#pragma once

#include <QWidget>

#include "Adapters/Rendering/OverlayScene.h"

class QComboBox;
class QDoubleSpinBox;
class QLabel;
class QPushButton;
class QSlider;
class QTableWidget;
class QCheckBox;

namespace kerf {
struct IntraoperativeSnapshot;
}

/// Step 3: the overlay's look, the cuts and what was said about them.
class qKerfRunPanel : public QWidget {
  Q_OBJECT
 public:
  explicit qKerfRunPanel(QWidget* parent = nullptr);

  void Update(const kerf::IntraoperativeSnapshot& snapshot);
  void SetPreset(kerf::OverlayPreset preset);
  void SetDrawing(bool drawing);
  void SetOverlay(bool on);
  bool HoldsCuts() const;
  void SetHoldsCuts(bool hold);
  double MarginAlarm_mm() const;
  /// The proposal or cut that the keys act on: the selected one, else the newest; −1: none.
  int CurrentCut(const kerf::IntraoperativeSnapshot& snapshot, bool proposals_only) const;

 signals:
  void PresetChanged(kerf::OverlayPreset preset);
  void OpacityChanged(double opacity);
  void OverlayToggled(bool on);
  void MarginAlarmChanged(double mm);
  void HoldChanged(bool hold);
  void AcceptWanted();
  void RejectWanted();
  void UndoWanted();
  void DrawToggled(bool drawing);
  void ConfirmWanted();
  void SnapshotWanted();
  void MarkWanted();
  void StopWanted();

 private:
  QComboBox* preset_;
  QSlider* opacity_;
  QDoubleSpinBox* alarm_;
  QPushButton *overlay_, *accept_, *reject_, *undo_, *draw_, *confirm_;
  QCheckBox* hold_;
  QTableWidget* cuts_;
  QLabel *said_, *recording_;
};
