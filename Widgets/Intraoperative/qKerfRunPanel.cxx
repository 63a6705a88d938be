#include "Intraoperative/qKerfRunPanel.h"

#include <QCheckBox>
#include <QHeaderView>
#include <QLabel>
#include <QPushButton>
#include <QTableWidget>
#include <QVBoxLayout>

#include "Common/qKerfTheme.h"
#include "Intraoperative/PanelButton.h"
#include "Session/IntraoperativeSnapshot.h"

using kerf::PanelButton;

namespace {

QString StateWord(const kerf::CutItem& cut) {
  switch (cut.state) {
    case kerf::CutItem::State::Proposed:
      return qKerfRunPanel::tr("proposed");
    case kerf::CutItem::State::Applied:
      return cut.partial ? qKerfRunPanel::tr("in the model in part")
                         : qKerfRunPanel::tr("in the model");
    case kerf::CutItem::State::Rejected:
      return qKerfRunPanel::tr("rejected");
  }
  return {};
}

}  // namespace

qKerfRunPanel::qKerfRunPanel(QWidget* parent) : QWidget(parent) {
  auto* layout = new QVBoxLayout(this);
  confirm_ = PanelButton(tr("The registration is right again (C)"), "confirm",
                         tr("After a loss the overlay stays off until you say so."));
  confirm_->setStyleSheet("background: #b3541e; color: white; font-weight: bold;");
  confirm_->hide();
  layout->addWidget(confirm_);

  hold_ = new QCheckBox(tr("Cuts wait to be accepted"));
  hold_->setObjectName("hold");
  hold_->setFocusPolicy(Qt::NoFocus);
  layout->addWidget(hold_);
  cuts_ = new QTableWidget(0, 5);
  cuts_->setObjectName("cuts");
  cuts_->setHorizontalHeaderLabels({tr("Cut"), tr("at"), tr("mm"), tr("sure"), tr("state")});
  cuts_->horizontalHeader()->setSectionResizeMode(QHeaderView::ResizeToContents);
  cuts_->horizontalHeader()->setStretchLastSection(true);
  cuts_->verticalHeader()->hide();
  cuts_->setSelectionBehavior(QAbstractItemView::SelectRows);
  cuts_->setSelectionMode(QAbstractItemView::SingleSelection);
  cuts_->setEditTriggers(QAbstractItemView::NoEditTriggers);
  cuts_->setFocusPolicy(Qt::NoFocus);
  layout->addWidget(cuts_, 1);
  auto* decide = new QHBoxLayout;
  accept_ = PanelButton(tr("Accept (A)"), "accept", tr("Cuts the model along the proposal."));
  reject_ =
      PanelButton(tr("Reject (R)"), "reject", tr("This is no cut: takes it out of the model."));
  undo_ = PanelButton(tr("Undo (Z)"), "undo", tr("Takes the last decision back."));
  draw_ = PanelButton(tr("Draw (D)"), "draw", tr("Draw a cut into the picture."));
  draw_->setCheckable(true);
  for (auto* button : {accept_, reject_}) decide->addWidget(button);
  layout->addLayout(decide);
  auto* change = new QHBoxLayout;
  for (auto* button : {undo_, draw_}) change->addWidget(button);
  layout->addLayout(change);
  said_ = new QLabel;
  said_->setObjectName("said");
  said_->setWordWrap(true);
  said_->setMinimumHeight(40);
  layout->addWidget(said_);
  auto* keep = new QHBoxLayout;
  auto* snapshot = PanelButton(tr("Snapshot (S)"), "snapshot", tr("Keeps this picture."));
  auto* mark = PanelButton(tr("Mark (M)"), "mark", tr("A mark in the journal."));
  keep->addWidget(snapshot);
  keep->addWidget(mark);
  layout->addLayout(keep);
  clamp_ = PanelButton(QString(), "clamp", tr("Counts the time of ischaemia; in the journal."));
  clamp_->setCheckable(true);
  clamp_->setStyleSheet("font-size: 13pt; font-weight: bold;");
  SetClamp(false, 0);
  layout->addWidget(clamp_);
  recording_ = new QLabel;
  recording_->setObjectName("recording");
  recording_->setWordWrap(true);
  layout->addWidget(recording_);
  auto* stop =
      PanelButton(tr("End the session"), "stop", tr("Completes the recording; then export."));
  layout->addWidget(stop);

  connect(hold_, &QCheckBox::toggled, this, &qKerfRunPanel::HoldChanged);
  connect(accept_, &QPushButton::clicked, this, &qKerfRunPanel::AcceptWanted);
  connect(reject_, &QPushButton::clicked, this, &qKerfRunPanel::RejectWanted);
  connect(undo_, &QPushButton::clicked, this, &qKerfRunPanel::UndoWanted);
  connect(draw_, &QPushButton::toggled, this, &qKerfRunPanel::DrawToggled);
  connect(confirm_, &QPushButton::clicked, this, &qKerfRunPanel::ConfirmWanted);
  connect(snapshot, &QPushButton::clicked, this, &qKerfRunPanel::SnapshotWanted);
  connect(mark, &QPushButton::clicked, this, &qKerfRunPanel::MarkWanted);
  connect(clamp_, &QPushButton::clicked, this, &qKerfRunPanel::ClampToggled);
  connect(stop, &QPushButton::clicked, this, &qKerfRunPanel::StopWanted);
}

void qKerfRunPanel::SetDrawing(bool drawing) { draw_->setChecked(drawing); }
void qKerfRunPanel::SetClamp(bool closed, int seconds) {
  clamp_->setChecked(closed);
  const QString time =
      QString("%1:%2").arg(seconds / 60).arg(seconds % 60, 2, 10, QLatin1Char('0'));
  clamp_->setText(closed        ? tr("Ischaemia %1  (K: open)").arg(time)
                  : seconds > 0 ? tr("Clamp (K) · was closed %1").arg(time)
                                : tr("Clamp (K)"));
}

bool qKerfRunPanel::HoldsCuts() const { return hold_->isChecked(); }
void qKerfRunPanel::SetHoldsCuts(bool hold) { hold_->setChecked(hold); }

int qKerfRunPanel::CurrentCut(const kerf::IntraoperativeSnapshot& snapshot,
                              bool proposals_only) const {
  const auto fits = [&](const kerf::CutItem& cut) {
    return cut.state == kerf::CutItem::State::Proposed ||
           (!proposals_only && cut.state == kerf::CutItem::State::Applied);
  };
  const int row = cuts_->currentRow();
  for (const kerf::CutItem& cut : snapshot.cuts)
    if (cut.number == row && fits(cut)) return cut.number;
  for (auto cut = snapshot.cuts.rbegin(); cut != snapshot.cuts.rend(); ++cut)
    if (fits(*cut)) return cut->number;
  return -1;
}

void qKerfRunPanel::Update(const kerf::IntraoperativeSnapshot& snapshot) {
  // Not while there is nothing to look at.
  confirm_->setVisible(snapshot.needs_confirmation && snapshot.source.Usable());
  cuts_->setRowCount(static_cast<int>(snapshot.cuts.size()));
  for (int row = 0; row < cuts_->rowCount(); ++row) {
    const kerf::CutItem& cut = snapshot.cuts[row];
    const QString texts[] = {
        QString::number(cut.number + 1), QString::number(cut.time_s, 'f', 2) + " s",
        QString::number(cut.length_mm, 'f', 0),
        cut.drawn ? tr("drawn") : QString::number(cut.confidence * 100, 'f', 0) + " %",
        StateWord(cut)};
    for (int column = 0; column < 5; ++column) {
      if (!cuts_->item(row, column)) cuts_->setItem(row, column, new QTableWidgetItem);
      auto* item = cuts_->item(row, column);
      if (item->text() != texts[column]) item->setText(texts[column]);
      item->setToolTip(cut.partial ? tr("A part of this cut could not be made in the model without "
                                        "badly shaped elements; tissue is still joined there.")
                                   : QString());
      item->setForeground(
          cut.state == kerf::CutItem::State::Proposed   ? qKerfTheme::Current().warning
          : cut.state == kerf::CutItem::State::Rejected ? qKerfTheme::Current().faint
                                                        : palette().color(QPalette::Text));
    }
  }
  accept_->setEnabled(CurrentCut(snapshot, true) >= 0);
  reject_->setEnabled(CurrentCut(snapshot, false) >= 0);
  for (auto* button : {accept_, reject_, undo_, draw_})
    button->setVisible(snapshot.stopped.empty());
  said_->setText(QString::fromStdString(snapshot.said));
  if (!snapshot.recording_problem.empty())
    recording_->setText(tr("<b style='color:%2'>Recording has stopped:</b> %1")
                            .arg(QString::fromStdString(snapshot.recording_problem).toHtmlEscaped(),
                                 qKerfTheme::Current().problem.name()));
  else
    recording_->setText(snapshot.recording ? tr("● recording") : tr("not recorded"));
}
