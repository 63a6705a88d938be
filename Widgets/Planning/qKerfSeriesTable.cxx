#include "Planning/qKerfSeriesTable.h"

#include <QHBoxLayout>
#include <QHeaderView>
#include <QLabel>
#include <QPushButton>
#include <QTreeWidget>
#include <QVBoxLayout>

#include "Planning/PanelParts.h"

using namespace kerf_panel;

namespace {
enum Column { kSeries, kPatient, kSide, kPhase, kSlices, kSpacing, kColumns };
}

qKerfSeriesTable::qKerfSeriesTable(QWidget* parent) : QWidget(parent), series_(new QTreeWidget) {
  series_->setObjectName("seriesTable");
  series_->setHeaderLabels(
      {tr("Series"), tr("Patient"), tr("Side"), tr("Contrast"), tr("Slices"), tr("Spacing, mm")});
  series_->setRootIsDecorated(false);
  series_->setAlternatingRowColors(true);
  series_->setMinimumHeight(150);
  series_->header()->setStretchLastSection(false);
  series_->header()->setSectionResizeMode(QHeaderView::ResizeToContents);
  series_->header()->setSectionResizeMode(kSeries, QHeaderView::Stretch);
  auto* open = Primary(tr("Open this series"), "openSeriesButton");
  auto* row = new QHBoxLayout;
  row->addWidget(new QLabel(tr("Choose the series to plan on:")));
  row->addStretch(1);
  row->addWidget(open);
  auto* column = new QVBoxLayout(this);
  column->setContentsMargins(4, 0, 4, 4);
  column->addLayout(row);
  column->addWidget(series_);
  const auto choose = [this] {
    if (const QTreeWidgetItem* item = series_->currentItem())
      emit Chosen(folder_, item->data(0, Qt::UserRole).toString());
  };
  connect(open, &QPushButton::clicked, this, choose);
  connect(series_, &QTreeWidget::itemActivated, this, choose);
  hide();
}

void qKerfSeriesTable::SetSeries(const QString& folder, const QVector<Series>& series) {
  folder_ = folder;
  series_->clear();
  for (const Series& s : series) {
    auto* item = new QTreeWidgetItem(
        series_, {s.modality + ' ' + (s.description.isEmpty() ? s.uid : s.description), s.patient,
                  s.laterality, s.phase, QString::number(s.slices), s.spacing});
    item->setData(0, Qt::UserRole, s.uid);
    item->setToolTip(kSeries, s.uid);
    item->setTextAlignment(kSlices, Qt::AlignRight | Qt::AlignVCenter);
  }
  if (series_->topLevelItemCount() > 0) series_->setCurrentItem(series_->topLevelItem(0));
  setVisible(!series.isEmpty());
}
