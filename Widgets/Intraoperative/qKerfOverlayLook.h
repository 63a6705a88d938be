#pragma once

#include <QWidget>

#include "Adapters/Rendering/OverlayScene.h"

class QComboBox;
class QDoubleSpinBox;
class QPushButton;
class QSlider;

/// How the overlay looks: on and off, preset, opacity, below which distance to the tumour a cut is
/// an alarm, and whether the state before a cut stands beside it.
class qKerfOverlayLook : public QWidget {
  Q_OBJECT
 public:
  explicit qKerfOverlayLook(QWidget* parent = nullptr);

  void SetPreset(kerf::OverlayPreset preset);
  void SetOverlay(bool on);
  void SetBefore(bool before);
  double MarginAlarm_mm() const;
  /// @param mm not above 0: the usual 5 mm
  void SetMarginAlarm(double mm);

 signals:
  void PresetChanged(kerf::OverlayPreset preset);
  void OpacityChanged(double opacity);
  void OverlayToggled(bool on);
  void MarginAlarmChanged(double mm);
  void BeforeToggled(bool before);

 private:
  QPushButton *overlay_, *before_;
  QComboBox* preset_;
  QSlider* opacity_;
  QDoubleSpinBox* alarm_;
};
