// A recorded session: played at the speed at which it was, and looked at anywhere.
#include <QPushButton>

#include "Intraoperative/OverlayPainter.h"
#include "Intraoperative/qKerfCheckInPanel.h"
#include "Intraoperative/qKerfIntraoperativeWidget.h"
#include "Intraoperative/qKerfReviewPanel.h"
#include "Intraoperative/qKerfTimeline.h"
#include "Pipelines/SessionPlayback.h"

using Clock = std::chrono::steady_clock;

void qKerfIntraoperativeWidget::ConnectReview() {
  connect(check_in_, &qKerfCheckInPanel::PlayWanted, this,
          &qKerfIntraoperativeWidget::OpenRecorded);
  connect(play_session_, &QPushButton::clicked, this,
          [this] { OpenRecorded(QString::fromStdString(desk_.SessionPath())); });
  connect(review_, &qKerfReviewPanel::PlayToggled, this, &qKerfIntraoperativeWidget::SetPlaying);
  connect(review_, &qKerfReviewPanel::FrameWanted, this, &qKerfIntraoperativeWidget::SeekTo);
  connect(review_, &qKerfReviewPanel::StepWanted, this,
          [this](int frames) { SeekTo(review_frame_ + frames); });
  connect(timeline_, &qKerfTimeline::Wanted, this, &qKerfIntraoperativeWidget::SeekTo);
}

void qKerfIntraoperativeWidget::OpenRecorded(const QString& session) {
  if (desk_.Running()) {
    services_.say_problem(tr("A session is running: end it before another one is played."));
    return;
  }
  auto opened = std::make_shared<std::unique_ptr<kerf::SessionPlayback>>();
  services_.run(
      tr("Opening the session"),
      [opened, path = session.toStdString()](kerf::Progress&) {
        *opened = std::make_unique<kerf::SessionPlayback>(path);
      },
      [this, opened] {
        if (desk_.Running()) return;  // begun meanwhile
        playback_ = std::move(*opened);
        painter_.reset();  // another camera
        shown_.reset();
        DrawAnew();
        shown_at_.Clear();
        review_frame_ = 0;
        timeline_->SetSession(playback_->FrameCount(), playback_->Events());
        review_->SetSession(*playback_);
        SetOverlay(true);
        ShowStep(Review);
      },
      [this](const QString& problem) {
        if (!problem.isEmpty()) services_.say_problem(problem);
      });
}

void qKerfIntraoperativeWidget::SetPlaying(bool playing) {
  if (playing && !playback_) return;
  if (playing && !playing_) {
    if (review_frame_ >= playback_->FrameCount() - 1) review_frame_ = 0;
    review_time_s_ = playback_->TimeOf_s(review_frame_);
    played_at_ = Clock::now();
  }
  playing_ = playing;
  review_->SetPlaying(playing);
}

/// A frame that is not done again yet is waited for.
void qKerfIntraoperativeWidget::SeekTo(int frame) {
  if (!playback_) return;
  review_frame_ = qBound(0, frame, playback_->FrameCount() - 1);
  review_time_s_ = playback_->TimeOf_s(review_frame_);
}

void qKerfIntraoperativeWidget::TickReview() {
  if (!playback_) return;
  TakePainted();
  const int ready = playback_->Ready(), last = playback_->FrameCount() - 1;
  timeline_->SetReady(ready);
  if (playing_ && ready > 0) {
    const auto now = Clock::now();
    const double passed_s = std::chrono::duration<double>(now - played_at_).count();
    played_at_ = now;
    review_time_s_ =
        qMin(review_time_s_ + passed_s * review_->Speed(), playback_->TimeOf_s(ready - 1));
    review_frame_ = playback_->FrameAt(review_time_s_);
    if (review_frame_ >= last || (!playback_->Problem().empty() && review_frame_ >= ready - 1))
      SetPlaying(false);
  }
  const int frame = qMin(review_frame_, ready - 1);
  review_->SetPlace(*playback_, qMax(0, frame));
  if (frame < 0 || !isVisible() || (drawn_ && drawn_->frame.index == frame)) return;
  try {
    Draw(playback_->At(frame), playback_->Camera());
    timeline_->setValue(frame);
  } catch (const std::exception& error) {
    services_.say_problem(QString::fromUtf8(error.what()));
    SetPlaying(false);
    if (shown_)
      review_frame_ = shown_->frame.index;
    else
      ShowStep(CheckIn);
  }
}
