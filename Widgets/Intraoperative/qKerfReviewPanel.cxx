#include "Intraoperative/qKerfReviewPanel.h"

#include <QComboBox>
#include <QFileInfo>
#include <QHBoxLayout>
#include <QLabel>
#include <QListWidget>
#include <QPushButton>
#include <QVBoxLayout>

#include "Common/qKerfTheme.h"
#include "Intraoperative/PanelButton.h"

using kerf::PanelButton;

qKerfReviewPanel::qKerfReviewPanel(QWidget* parent) : QWidget(parent) {
  auto* layout = new QVBoxLayout(this);
  title_ = new QLabel;
  title_->setWordWrap(true);
  layout->addWidget(title_);
  auto* play_row = new QHBoxLayout;
  play_ = PanelButton(tr("Play (Space)"), "review_play", tr("At the speed at which it was."));
  play_->setCheckable(true);
  speed_ = new QComboBox;
  speed_->setObjectName("review_speed");
  speed_->setFocusPolicy(Qt::NoFocus);
  for (const double factor : {0.25, 0.5, 1.0, 2.0, 4.0})
    speed_->addItem(tr("%1 ×").arg(factor), factor);
  speed_->setCurrentIndex(2);
  auto* back = PanelButton(QStringLiteral("◀"), "review_back", tr("One picture back (Left)"));
  auto* on = PanelButton(QStringLiteral("▶"), "review_on", tr("One picture on (Right)"));
  play_row->addWidget(play_, 2);
  play_row->addWidget(speed_, 1);
  play_row->addWidget(back);
  play_row->addWidget(on);
  layout->addLayout(play_row);
  place_ = new QLabel;
  place_->setObjectName("review_place");
  place_->setStyleSheet("font-size: 13pt; font-weight: bold;");
  layout->addWidget(place_);
  layout->addWidget(new QLabel(tr("What happened (click to go there):")));
  events_ = new QListWidget;
  events_->setObjectName("review_events");
  events_->setFocusPolicy(Qt::NoFocus);
  events_->setWordWrap(true);
  layout->addWidget(events_, 1);
  state_ = new QLabel;
  state_->setObjectName("review_state");
  state_->setWordWrap(true);
  layout->addWidget(state_);

  connect(play_, &QPushButton::toggled, this, &qKerfReviewPanel::PlayToggled);
  connect(back, &QPushButton::clicked, this, [this] { emit StepWanted(-1); });
  connect(on, &QPushButton::clicked, this, [this] { emit StepWanted(1); });
  connect(events_, &QListWidget::itemClicked, this,
          [this](QListWidgetItem* item) { emit FrameWanted(item->data(Qt::UserRole).toInt()); });
}

void qKerfReviewPanel::SetSession(const kerf::SessionPlayback& playback) {
  const kerf::SessionFolder& session = playback.Session();
  title_->setText(tr("<b>Session %1</b><br>%2%3")
                      .arg(QFileInfo(QString::fromStdString(session.root)).fileName(),
                           QString::fromStdString(session.source_name).toHtmlEscaped(),
                           session.finished ? QString() : tr(" · was broken off")));
  events_->clear();
  for (const kerf::PlaybackEvent& event : playback.Events()) {
    auto* item = new QListWidgetItem(
        tr("%1 s  %2").arg(event.time_s, 0, 'f', 2).arg(QString::fromStdString(event.words)));
    item->setData(Qt::UserRole, event.frame);
    events_->addItem(item);
  }
}

void qKerfReviewPanel::SetPlace(const kerf::SessionPlayback& playback, int frame) {
  place_->setText(tr("%1 of %2 s · frame %3")
                      .arg(playback.TimeOf_s(frame), 0, 'f', 2)
                      .arg(playback.TimeOf_s(playback.FrameCount() - 1), 0, 'f', 2)
                      .arg(frame));
  const int ready = playback.Ready();
  const std::string problem = playback.Problem();
  state_->setText(
      !problem.empty() ? tr("<b style='color:%3'>Only the first %1 frames:</b> %2")
                             .arg(ready)
                             .arg(QString::fromStdString(problem).toHtmlEscaped(),
                                  qKerfTheme::Current().problem.name())
      : ready < playback.FrameCount()
          ? tr("Doing the session again: %1 of %2 frames").arg(ready).arg(playback.FrameCount())
          : tr("The same states as recorded, frame by frame."));
}

void qKerfReviewPanel::SetPlaying(bool playing) { play_->setChecked(playing); }
double qKerfReviewPanel::Speed() const { return speed_->currentData().toDouble(); }
