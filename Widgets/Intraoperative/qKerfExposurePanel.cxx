#include "Intraoperative/qKerfExposurePanel.h"

#include <QButtonGroup>
#include <QHBoxLayout>
#include <QHeaderView>
#include <QLabel>
#include <QPushButton>
#include <QTableWidget>
#include <QVBoxLayout>
#include <algorithm>
#include <cmath>

#include "Common/qKerfTheme.h"
#include "Pipelines/ExposureRegistration.h"

namespace {
enum Column { kUse, kName, kPixels, kMillimetres };
}

qKerfExposurePanel::qKerfExposurePanel(QWidget* parent) : QWidget(parent) {
  auto* layout = new QVBoxLayout(this);
  guide_ = new QLabel;
  guide_->setObjectName("guide");
  guide_->setWordWrap(true);
  guide_->setStyleSheet("font-size: 15pt; font-weight: bold;");
  guide_->setMinimumHeight(76);
  layout->addWidget(guide_);

  auto* modes = new QHBoxLayout;
  auto* group = new QButtonGroup(this);
  const auto mode = [&](const QString& text, const char* name) {
    auto* button = new QPushButton(text);
    button->setCheckable(true);
    button->setObjectName(name);
    group->addButton(button);
    modes->addWidget(button);
    return button;
  };
  landmarks_mode_ = mode(tr("Landmarks"), "landmarks_mode");
  hand_mode_ = mode(tr("By hand"), "hand_mode");
  trace_mode_ = mode(tr("Trace outline"), "trace_mode");
  landmarks_mode_->setChecked(true);
  layout->addLayout(modes);

  table_ = new QTableWidget(0, 4);
  table_->setObjectName("landmarks");
  table_->setHorizontalHeaderLabels({tr("Use"), tr("Landmark"), tr("px"), tr("mm")});
  table_->horizontalHeader()->setSectionResizeMode(QHeaderView::ResizeToContents);
  table_->horizontalHeader()->setSectionResizeMode(kName, QHeaderView::Stretch);
  table_->verticalHeader()->hide();
  table_->setSelectionBehavior(QAbstractItemView::SelectRows);
  table_->setSelectionMode(QAbstractItemView::SingleSelection);
  table_->setEditTriggers(QAbstractItemView::NoEditTriggers);
  layout->addWidget(table_, 1);
  advice_ = new QLabel;
  advice_->setObjectName("advice");
  advice_->setWordWrap(true);
  layout->addWidget(advice_);

  auto* ways = new QHBoxLayout;
  given_ = new QPushButton(tr("Given pose"));
  given_->setObjectName("given");
  auto* contour = new QPushButton(tr("Fit outline"));
  contour->setObjectName("contour");
  undo_ = new QPushButton(tr("Undo"));
  undo_->setObjectName("undo_pose");
  ways->addWidget(given_);
  ways->addWidget(contour);
  ways->addWidget(undo_);
  layout->addLayout(ways);
  auto* picture = new QPushButton(tr("Take the present picture"));
  layout->addWidget(picture);
  fit_ = new QLabel;
  fit_->setObjectName("fit");
  fit_->setStyleSheet("font-size: 14pt;");
  layout->addWidget(fit_);
  accept_ = new QPushButton(tr("Accept the registration"));
  accept_->setObjectName("accept_registration");
  accept_->setProperty("primary", true);
  accept_->setMinimumHeight(52);
  accept_->setStyleSheet("font-size: 14pt; font-weight: bold;");
  layout->addWidget(accept_);

  connect(given_, &QPushButton::clicked, this, &qKerfExposurePanel::GivenWanted);
  connect(contour, &QPushButton::clicked, this, &qKerfExposurePanel::ContourWanted);
  connect(undo_, &QPushButton::clicked, this, &qKerfExposurePanel::UndoWanted);
  connect(picture, &QPushButton::clicked, this, &qKerfExposurePanel::NewPictureWanted);
  connect(accept_, &QPushButton::clicked, this, &qKerfExposurePanel::Accepted);
  connect(group, QOverload<QAbstractButton*, bool>::of(&QButtonGroup::buttonToggled), this,
          &qKerfExposurePanel::ModeChanged);
  connect(table_, &QTableWidget::itemChanged, this, [this](QTableWidgetItem* item) {
    if (!filling_ && item->column() == kUse)
      emit ExcludeWanted(item->row(), item->checkState() != Qt::Checked);
  });
  connect(table_, &QTableWidget::cellDoubleClicked, this,
          [this](int row, int) { emit RemoveWanted(row); });
}

bool qKerfExposurePanel::PlacingLandmarks() const { return landmarks_mode_->isChecked(); }
bool qKerfExposurePanel::Tracing() const { return trace_mode_->isChecked(); }
int qKerfExposurePanel::Selected() const { return table_->currentRow(); }
void qKerfExposurePanel::Select(int landmark) { table_->selectRow(landmark); }

void qKerfExposurePanel::Update(const kerf::ExposureRegistration& exposure, double contour_fit) {
  filling_ = true;
  const auto& landmarks = exposure.Landmarks();
  table_->setRowCount(static_cast<int>(landmarks.size()));
  for (int row = 0; row < table_->rowCount(); ++row) {
    const kerf::ExposureLandmark& landmark = landmarks[row];
    for (int column = 0; column < 4; ++column)
      if (!table_->item(row, column)) table_->setItem(row, column, new QTableWidgetItem);
    table_->item(row, kUse)->setFlags(landmark.pixel ? Qt::ItemIsEnabled | Qt::ItemIsUserCheckable |
                                                           Qt::ItemIsSelectable
                                                     : Qt::ItemIsEnabled | Qt::ItemIsSelectable);
    table_->item(row, kUse)->setCheckState(landmark.excluded ? Qt::Unchecked : Qt::Checked);
    table_->item(row, kName)->setText(QString::fromStdString(landmark.name));
    const auto number = [](double v) { return std::isfinite(v) ? QString::number(v, 'f', 1) : ""; };
    table_->item(row, kPixels)->setText(landmark.pixel ? number(landmark.residual_px) : "");
    table_->item(row, kMillimetres)->setText(landmark.pixel ? number(landmark.residual_mm) : "");
    const QColor color = landmark.outlier    ? qKerfTheme::Current().problem
                         : landmark.excluded ? qKerfTheme::Current().faint
                                             : palette().color(QPalette::Text);
    for (int column = 0; column < 4; ++column) table_->item(row, column)->setForeground(color);
  }
  const int next = exposure.NextLandmark();
  if (next >= 0) table_->selectRow(next);
  filling_ = false;

  if (Tracing())
    guide_->setText(tr("Trace the organ's outline with the mouse, then “Fit outline”."));
  else if (!PlacingLandmarks())
    guide_->setText(
        tr("Drag: move. Right button: turn. Wheel: nearer or farther. Shift+wheel: roll."));
  else if (landmarks.empty())
    guide_->setText(tr("The case has no landmarks: register by hand or with the outline."));
  else if (next >= 0)
    guide_->setText(
        tr("Click on “%1” in the picture.").arg(QString::fromStdString(landmarks[next].name)));
  else
    guide_->setText(tr("All landmarks are placed. Check the outline."));
  // Of who registers by hand no landmark is asked.
  const bool placed = std::any_of(landmarks.begin(), landmarks.end(),
                                  [](const auto& landmark) { return landmark.pixel.has_value(); });
  advice_->setText(PlacingLandmarks() || placed ? QString::fromStdString(exposure.LandmarkAdvice())
                                                : QString());
  given_->setEnabled(exposure.HasGiven());
  undo_->setEnabled(exposure.CanUndo());
  fit_->setText(
      (exposure.IsTraced() ? tr("Traced outline agrees: %1 %") : tr("Outline agrees: %1 %"))
          .arg(contour_fit * 100, 0, 'f', 0));
}
