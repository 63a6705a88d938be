// Run and close: the part of the page that shows the overlay and takes decisions.
#include <QLabel>
#include <QLineF>
#include <QListWidget>
#include <QPushButton>
#include <cmath>

#include "Adapters/Rendering/VirtualDisplay.h"
#include "Intraoperative/OverlayPainter.h"
#include "Intraoperative/qKerfIntraoperativeWidget.h"
#include "Intraoperative/qKerfRunPanel.h"
#include "Intraoperative/qKerfVideoView.h"

namespace {

using Kind = kerf::IntraoperativeDecision::Kind;
using Clock = std::chrono::steady_clock;
constexpr double kStrokeStep_px = 4.0;

}  // namespace

void qKerfIntraoperativeWidget::ConnectRun() {
  connect(run_, &qKerfRunPanel::PresetChanged, this, &qKerfIntraoperativeWidget::SetPreset);
  connect(run_, &qKerfRunPanel::OpacityChanged, this, [this](double opacity) {
    if (!painter_) return;
    kerf::OverlayOptions options = painter_->Options();
    options.organ_opacity = opacity;
    painter_->SetOptions(options);
    shown_.reset();
  });
  connect(run_, &qKerfRunPanel::MarginAlarmChanged, this, [this](double mm) {
    if (painter_) painter_->SetMarginAlarm(mm);
  });
  connect(run_, &qKerfRunPanel::OverlayToggled, this, &qKerfIntraoperativeWidget::SetOverlay);
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
  connect(run_, &qKerfRunPanel::StopWanted, this, &qKerfIntraoperativeWidget::EndSession);

  connect(view_, &qKerfVideoView::Pressed, this, [this](const QPointF& at, Qt::MouseButton button) {
    if (step_ != Run || button != Qt::LeftButton) return;
    if (drawing_) {
      stroke_ = QPolygonF() << at;
    } else if (painter_ && painter_->Options().preset == kerf::OverlayPreset::SeeThrough) {
      kerf::OverlayOptions options = painter_->Options();  // the window goes where one clicks
      options.window_px = kerf::Vec2(at.x(), at.y());
      painter_->SetOptions(options);
      shown_.reset();
    }
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

void qKerfIntraoperativeWidget::SetPreset(kerf::OverlayPreset preset) {
  run_->SetPreset(preset);
  if (!painter_) return;
  kerf::OverlayOptions options = painter_->Options();
  options.preset = preset;
  options.window_px.reset();
  painter_->SetOptions(options);
  shown_.reset();
}

void qKerfIntraoperativeWidget::SetOverlay(bool on) {
  overlay_on_ = on;
  run_->SetOverlay(on);
  view_->SetBanner(on ? QString() : tr("OVERLAY OFF  (O)"));
  shown_.reset();
}

void qKerfIntraoperativeWidget::SetDrawing(bool drawing) {
  drawing_ = drawing && step_ == Run;
  run_->SetDrawing(drawing_);
  stroke_.clear();
  view_->SetStroke(stroke_);
  view_->setCursor(drawing_ ? Qt::CrossCursor : Qt::ArrowCursor);
}

void qKerfIntraoperativeWidget::TickRun() {
  const auto latest = desk_.Latest();
  if (!latest || latest == shown_) return;
  Try([&] {
    std::string why_not;
    if (!painter_ && kerf::RenderingAvailable(&why_not)) {
      painter_ = std::make_unique<kerf::OverlayPainter>(desk_.Camera());
      painter_->SetMarginAlarm(run_->MarginAlarm_mm());
    }
    const bool new_picture = !shown_ || shown_->captured != latest->captured;
    shown_ = latest;
    if (painter_ && overlay_on_)
      view_->SetPicture(painter_->Paint(*latest));
    else if (latest->frame.image)
      view_->SetPicture(*latest->frame.image);
    if (raw_->isVisible() && latest->frame.image) raw_->SetPicture(*latest->frame.image);
    run_->Update(*latest);
    ShowLamp(*latest);
    const auto now = Clock::now();
    if (new_picture) {
      shown_at_.push_back(now);
      while (now - shown_at_.front() > std::chrono::seconds(1)) shown_at_.pop_front();
      latency_ms_ = std::chrono::duration<double, std::milli>(now - latest->captured).count();
    }
    ShowFigures(latest->source, latest->registered_fps);
  });
}

void qKerfIntraoperativeWidget::ShowLamp(const kerf::IntraoperativeSnapshot& snapshot) {
  const bool green = snapshot.gate == kerf::GateState::Green;
  const bool amber = snapshot.gate == kerf::GateState::Amber;
  QString text = green ? tr("OVERLAY OK") : amber ? tr("CAUTION") : tr("OVERLAY OFF");
  if (!green) text += ": " + QString::fromStdString(snapshot.reason);
  if (std::isfinite(snapshot.reliability.tumour_u95_mm) && snapshot.gate != kerf::GateState::Off)
    text += tr("   tumour ± %1 mm").arg(snapshot.reliability.tumour_u95_mm, 0, 'f', 1);
  lamp_->setText(text);
  lamp_->setStyleSheet(QString("font-size: 16pt; font-weight: bold; padding: 4px; color: %1; "
                               "background: %2;")
                           .arg(amber ? "black" : "white", green   ? "#1f7a3d"
                                                           : amber ? "#ffbe3c"
                                                                   : "#b3261e"));
  if (std::isfinite(snapshot.margin_mm)) {
    const bool alarm = snapshot.margin_mm < run_->MarginAlarm_mm();
    margin_->setText(tr("tumour – cut %1 mm").arg(snapshot.margin_mm, 0, 'f', 1));
    margin_->setStyleSheet(alarm ? "font-size: 16pt; font-weight: bold; color: white; "
                                   "background: #b3261e; padding: 4px;"
                                 : "font-size: 16pt; font-weight: bold; padding: 4px;");
  } else {
    margin_->clear();
    margin_->setStyleSheet(QString());
  }
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
    const std::string path = desk_.KeepPicture(image, shown_->frame.index);
    if (!path.empty()) services_.say(tr("Snapshot kept: %1").arg(QString::fromStdString(path)));
  });
}

void qKerfIntraoperativeWidget::EndSession() {
  Try([&] {
    desk_.Stop();
    exported_->clear();
    const QString path = QString::fromStdString(desk_.SessionPath());
    export_->setEnabled(!path.isEmpty());
    close_text_->setText(path.isEmpty()
                             ? tr("The session was not recorded.")
                             : tr("<b>The session is complete.</b><br>%1<br><br>Its report is "
                                  "report.html. It can be played again with<br><code>kerf replay "
                                  "%1 --output results</code>")
                                   .arg(path.toHtmlEscaped()));
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
        for (const std::string& file : *files) exported_->addItem(QString::fromStdString(file));
        export_->setEnabled(true);
        services_.say(tr("%n file(s) exported.", "", static_cast<int>(files->size())));
      },
      [this](const QString& problem) {
        export_->setEnabled(true);
        services_.say_problem(problem);
      });
}
