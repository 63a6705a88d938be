// Run and close: the part of the page that takes decisions.
#include <QDir>
#include <QLabel>
#include <QLineF>
#include <QListWidget>
#include <QPushButton>

#include "Common/qKerfPaths.h"
#include "Common/qKerfTheme.h"
#include "Intraoperative/qKerfIntraoperativeWidget.h"
#include "Intraoperative/qKerfRunPanel.h"
#include "Intraoperative/qKerfVideoView.h"

namespace {

using Kind = kerf::IntraoperativeDecision::Kind;
using Clock = std::chrono::steady_clock;
constexpr double kStrokeStep_px = 4.0;
constexpr std::chrono::milliseconds kFigures(500);

}  // namespace

void qKerfIntraoperativeWidget::ConnectRun() {
  connect(run_, &qKerfRunPanel::HoldChanged, this, [this](bool hold) {
    if (desk_.Running()) Post(hold ? Kind::HoldCuts : Kind::TakeCuts);
  });
  connect(run_, &qKerfRunPanel::AcceptWanted, this, [this] { DecideOnCut(true); });
  connect(run_, &qKerfRunPanel::RejectWanted, this, [this] { DecideOnCut(false); });
  connect(run_, &qKerfRunPanel::UndoWanted, this, [this] { Post(Kind::Undo); });
  connect(run_, &qKerfRunPanel::ConfirmWanted, this, [this] { Post(Kind::Confirm); });
  connect(run_, &qKerfRunPanel::DrawToggled, this, &qKerfIntraoperativeWidget::SetDrawing);
  connect(run_, &qKerfRunPanel::SnapshotWanted, this, &qKerfIntraoperativeWidget::KeepSnapshot);
  connect(run_, &qKerfRunPanel::MarkWanted, this, [this] { desk_.Mark("button"); });
  connect(run_, &qKerfRunPanel::ClampToggled, this, &qKerfIntraoperativeWidget::SetClamp);
  connect(run_, &qKerfRunPanel::StopWanted, this, &qKerfIntraoperativeWidget::EndSession);

  connect(view_, &qKerfVideoView::Pressed, this, [this](const QPointF& at, Qt::MouseButton button) {
    if (step_ == Run && button == Qt::LeftButton && drawing_) stroke_ = QPolygonF() << at;
  });
  connect(view_, &qKerfVideoView::Dragged, this,
          [this](const QPointF&, const QPointF& to, Qt::MouseButtons, Qt::KeyboardModifiers) {
            if (step_ != Run || !drawing_ || stroke_.isEmpty()) return;
            if (QLineF(stroke_.last(), to).length() < kStrokeStep_px) return;
            stroke_ << to;
            view_->SetStroke(stroke_);
          });
  connect(view_, &qKerfVideoView::Released, this, [this](const QPointF& at, Qt::MouseButton) {
    if (step_ != Run || !drawing_ || stroke_.isEmpty()) return;
    stroke_ << at;
    kerf::IntraoperativeDecision drawn;
    drawn.kind = Kind::DrawCut;
    drawn.stroke.resize(stroke_.size(), 2);
    for (int i = 0; i < stroke_.size(); ++i) drawn.stroke.row(i) << stroke_[i].x(), stroke_[i].y();
    desk_.Post(drawn);
    SetDrawing(false);
  });
}

void qKerfIntraoperativeWidget::Post(Kind kind, int cut) {
  kerf::IntraoperativeDecision decision;
  decision.kind = kind;
  decision.cut = cut;
  desk_.Post(decision);
}

void qKerfIntraoperativeWidget::DecideOnCut(bool accept) {
  const auto latest = desk_.Latest();
  if (step_ != Run || !latest) return;
  const int cut = run_->CurrentCut(*latest, accept);
  if (cut >= 0) Post(accept ? Kind::AcceptCut : Kind::RejectCut, cut);
}

void qKerfIntraoperativeWidget::SetDrawing(bool drawing) {
  drawing_ = drawing && step_ == Run;
  run_->SetDrawing(drawing_);
  stroke_.clear();
  view_->SetStroke(stroke_);
  view_->setCursor(drawing_ ? Qt::CrossCursor : Qt::ArrowCursor);
}

void qKerfIntraoperativeWidget::TickRun() {
  if (clamped_at_) ShowClamp();
  TakePainted();
  if (isVisible()) ShowNewest();
  const auto latest = desk_.Current();
  if (!latest) {
    lamp_->setText(tr("OVERLAY OFF: the registration begins"));
    return;
  }
  if (Clock::now() - figures_at_ > kFigures) {
    figures_at_ = Clock::now();  // pictures may have stopped: the figures of then are none of now
    const bool quiet = figures_at_ - latest->captured > std::chrono::seconds(1);
    ShowFigures(desk_.Source(), quiet ? 0.0 : latest->registered_fps,
                !latest->recording_problem.empty());
  }
  SayWhatStopped(*latest);
  if (latest == drawn_ || !isVisible()) return;  // what nobody sees is not drawn
  Draw(latest, desk_.Camera());
  run_->Update(*latest);
}

/// The newest picture of all wherever no model lies over it: these wait for no registration.
void qKerfIntraoperativeWidget::ShowNewest() {
  const auto newest = desk_.Newest();
  if (!newest || !newest->frame.image || newest->captured == newest_shown_) return;
  newest_shown_ = newest->captured;
  if (!raw_->isHidden()) raw_->SetPicture(*newest->frame.image);
  if (shown_ && !Bare()) return;
  view_->SetPicture(*newest->frame.image);
  NoteShown(newest->captured);
}

void qKerfIntraoperativeWidget::SayWhatStopped(const kerf::IntraoperativeSnapshot& latest) {
  const auto say_once = [this](const std::string& now, std::string* said, const QString& words) {
    if (now == *said) return;
    *said = now;
    if (!now.empty()) services_.say_problem(words.arg(QString::fromStdString(now)));
  };
  say_once(latest.stopped, &stopped_,
           tr("The registration has stopped: %1. What was recorded is kept. Register "
              "again (step 2), or end the session."));
  say_once(latest.recording_problem, &not_recorded_,
           tr("The session goes on, but is not recorded from here on: %1. What was recorded is "
              "kept."));
}

void qKerfIntraoperativeWidget::SetClamp(bool closed) {
  if (step_ == Run && closed != clamped_at_.has_value()) {
    if (clamped_at_) clamped_before_ += Clock::now() - *clamped_at_;
    clamped_at_.reset();
    if (closed) clamped_at_ = Clock::now();
    desk_.Clamp(closed);
  }
  ShowClamp();
}

void qKerfIntraoperativeWidget::ShowClamp() {
  auto passed = clamped_before_;
  if (clamped_at_) passed += Clock::now() - *clamped_at_;
  run_->SetClamp(
      clamped_at_.has_value(),
      static_cast<int>(std::chrono::duration_cast<std::chrono::seconds>(passed).count()));
}

void qKerfIntraoperativeWidget::KeepSnapshot() {
  if (step_ != Run || !shown_) return;
  Try([&] {
    const QImage picture = view_->Picture().convertToFormat(QImage::Format_BGR888);
    kerf::Image image;
    image.width = picture.width();
    image.height = picture.height();
    image.channels = 3;
    image.data.resize(std::size_t(image.width) * image.height * 3);
    for (int y = 0; y < image.height; ++y)
      std::copy_n(picture.constScanLine(y), std::size_t(image.width) * 3,
                  image.data.begin() + std::size_t(y) * image.width * 3);
    // While the overlay is off the view is ahead of what is registered.
    const int frame = shown_->captured == shown_picture_ ? shown_->frame.index : -1;
    const std::string path = desk_.KeepPicture(image, frame, shown_picture_);
    if (path.empty())
      services_.say_problem(tr("Snapshot not kept: the session is not recorded."));
    else
      services_.say(tr("Snapshot kept: %1").arg(qKerfShortPath(QString::fromStdString(path))));
  });
}

void qKerfIntraoperativeWidget::EndRun(std::function<void()> then) {
  if (ending_.valid()) return;
  SetDrawing(false);
  lamp_->setText(tr("Completing the recording"));
  side_->setEnabled(false);
  after_end_ = std::move(then);
  // Not a job: it waits for none and cannot be cancelled.
  ending_ = std::async(std::launch::async, [this] { desk_.FinishRun(); });
}

void qKerfIntraoperativeWidget::TickEnd() {
  if (ending_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return;
  ending_ = {};
  side_->setEnabled(true);
  desk_.Stop();  // at once: it has ended
  after_end_();
}

void qKerfIntraoperativeWidget::EndSession() {
  if (desk_.Running()) EndRun([this] { ShowEnd(); });
}

void qKerfIntraoperativeWidget::ShowEnd() {
  Try([&] {
    exported_->clear();
    const QString path = qKerfShortPath(QString::fromStdString(desk_.SessionPath()));
    const QString problem = QString::fromStdString(desk_.RecordingProblem()).toHtmlEscaped();
    export_->setEnabled(!path.isEmpty());
    play_session_->setEnabled(!path.isEmpty());
    close_text_->setText(
        (path.isEmpty()       ? tr("<b>The session was not recorded.</b>")
         : !problem.isEmpty() ? tr("<b>The recording ended early.</b> What was written up to then "
                                   "is whole:<br>%1")
                                    .arg(path.toHtmlEscaped())
                              : tr("<b>The session is complete.</b><br>%1<br><br>Its report is "
                                   "report.html. <code>kerf replay</code> of this folder gives the "
                                   "same results again.")
                                    .arg(path.toHtmlEscaped())) +
        (problem.isEmpty() ? QString()
                           : QString("<br><span style='color:%1'>%2</span>")
                                 .arg(qKerfTheme::Current().problem.name(), problem)));
    ShowStep(Close);
    lamp_->setText(tr("Session ended"));
  });
}

void qKerfIntraoperativeWidget::ExportAll() {
  export_->setEnabled(false);
  auto files = std::make_shared<std::vector<std::string>>();
  services_.run(
      tr("Exporting"),
      [this, files](kerf::Progress& progress) { *files = desk_.ExportAll(progress); },
      [this, files] {
        const QDir session(QString::fromStdString(desk_.SessionPath()));
        for (const std::string& file : *files)
          exported_->addItem(session.relativeFilePath(QString::fromStdString(file)));
        export_->setEnabled(true);
        services_.say(tr("%n file(s) exported.", "", static_cast<int>(files->size())));
      },
      [this](const QString& problem) {
        export_->setEnabled(true);
        if (!problem.isEmpty()) services_.say_problem(problem);
      });
}
