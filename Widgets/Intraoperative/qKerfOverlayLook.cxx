#include "Intraoperative/qKerfOverlayLook.h"

#include <QComboBox>
#include <QDoubleSpinBox>
#include <QFormLayout>
#include <QPushButton>
#include <QSlider>

#include "Intraoperative/PanelButton.h"

namespace {
constexpr double kUsualAlarm_mm = 5;
}  // namespace

qKerfOverlayLook::qKerfOverlayLook(QWidget* parent) : QWidget(parent) {
  auto* form = new QFormLayout(this);
  overlay_ =
      kerf::PanelButton(tr("Overlay (O)"), "overlay", tr("Switches the overlay on and off."));
  overlay_->setCheckable(true);
  overlay_->setChecked(true);
  form->addRow(overlay_);
  preset_ = new QComboBox;
  preset_->setObjectName("preset");
  preset_->addItems({tr("Outline (1)"), tr("See-through (2)"), tr("Full (3)")});
  preset_->setFocusPolicy(Qt::NoFocus);
  form->addRow(tr("Shows"), preset_);
  opacity_ = new QSlider(Qt::Horizontal);
  opacity_->setObjectName("opacity");
  opacity_->setRange(5, 100);
  opacity_->setFocusPolicy(Qt::NoFocus);
  form->addRow(tr("Opacity"), opacity_);
  alarm_ = new QDoubleSpinBox;
  alarm_->setObjectName("alarm");
  alarm_->setRange(0, 50);
  alarm_->setValue(kUsualAlarm_mm);
  alarm_->setSuffix(tr(" mm"));
  alarm_->setFocusPolicy(Qt::ClickFocus);
  form->addRow(tr("Alarm below"), alarm_);
  before_ = kerf::PanelButton(tr("Before the cut (V)"), "before",
                              tr("Shows beside it how it was before the selected or last cut."));
  before_->setCheckable(true);
  form->addRow(before_);
  const kerf::OverlayOptions standard;
  preset_->setCurrentIndex(static_cast<int>(standard.preset));
  opacity_->setValue(static_cast<int>(standard.organ_opacity * 100));

  connect(overlay_, &QPushButton::toggled, this, &qKerfOverlayLook::OverlayToggled);
  connect(preset_, QOverload<int>::of(&QComboBox::currentIndexChanged), this,
          [this](int index) { emit PresetChanged(static_cast<kerf::OverlayPreset>(index)); });
  connect(opacity_, &QSlider::valueChanged, this,
          [this](int percent) { emit OpacityChanged(percent / 100.0); });
  connect(alarm_, QOverload<double>::of(&QDoubleSpinBox::valueChanged), this,
          &qKerfOverlayLook::MarginAlarmChanged);
  connect(before_, &QPushButton::toggled, this, &qKerfOverlayLook::BeforeToggled);
}

void qKerfOverlayLook::SetPreset(kerf::OverlayPreset preset) {
  preset_->setCurrentIndex(static_cast<int>(preset));
}
void qKerfOverlayLook::SetOverlay(bool on) { overlay_->setChecked(on); }
void qKerfOverlayLook::SetBefore(bool before) { before_->setChecked(before); }
double qKerfOverlayLook::MarginAlarm_mm() const { return alarm_->value(); }

void qKerfOverlayLook::SetMarginAlarm(double mm) { alarm_->setValue(mm > 0 ? mm : kUsualAlarm_mm); }
