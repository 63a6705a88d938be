// Exposure: the part of the page where the surgeon registers the organ.
#include <QGuiApplication>
#include <QLabel>
#include <QLineF>
#include <cmath>

#include "Adapters/Rendering/VirtualDisplay.h"
#include "Intraoperative/OverlayPainter.h"
#include "Intraoperative/qKerfCheckInPanel.h"
#include "Intraoperative/qKerfExposurePanel.h"
#include "Intraoperative/qKerfIntraoperativeWidget.h"
#include "Intraoperative/qKerfOverlayLook.h"
#include "Intraoperative/qKerfRunPanel.h"
#include "Intraoperative/qKerfVideoView.h"

namespace {

constexpr double kNearRim_px = 4.0, kTraceStep_px = 3.0;
constexpr double kApproachPerStep = 0.97, kRollPerStep_deg = 2.0;

kerf::Vec2 ToVec(const QPointF& p) { return {p.x(), p.y()}; }

}  // namespace

void qKerfIntraoperativeWidget::ConnectExposure() {
  const auto changed = [this] { exposure_changed_ = true; };
  connect(exposure_, &qKerfExposurePanel::GivenWanted, this, [=] {
    desk_.Exposure()->UseGiven();
    changed();
  });
  connect(exposure_, &qKerfExposurePanel::ContourWanted, this,
          &qKerfIntraoperativeWidget::FitOutline);
  connect(exposure_, &qKerfExposurePanel::UndoWanted, this, [=] {
    desk_.Exposure()->Undo();
    changed();
  });
  connect(exposure_, &qKerfExposurePanel::NewPictureWanted, this, [this] { BeginExposure(true); });
  connect(exposure_, &qKerfExposurePanel::ExcludeWanted, this, [=](int landmark, bool excluded) {
    desk_.Exposure()->Exclude(landmark, excluded);
    changed();
  });
  connect(exposure_, &qKerfExposurePanel::RemoveWanted, this, [=](int landmark) {
    desk_.Exposure()->Remove(landmark);
    changed();
  });
  connect(exposure_, &qKerfExposurePanel::ModeChanged, this, changed);
  connect(exposure_, &qKerfExposurePanel::Accepted, this, &qKerfIntraoperativeWidget::Accept);

  connect(view_, &qKerfVideoView::Pressed, this, [=](const QPointF& at, Qt::MouseButton button) {
    if (step_ != Exposure || !exposure_->PlacingLandmarks() || button != Qt::LeftButton) return;
    const QImage& picture = view_->Picture();
    if (at.x() < -kNearRim_px || at.y() < -kNearRim_px || at.x() > picture.width() + kNearRim_px ||
        at.y() > picture.height() + kNearRim_px)
      return;
    desk_.Exposure()->Place(exposure_->Selected(), ToVec(at));
    const int next = desk_.Exposure()->NextLandmark();
    if (next >= 0) exposure_->Select(next);  // at once: the next click may come soon
    changed();
  });
  connect(
      view_, &qKerfVideoView::Dragged, this,
      [=](const QPointF& from, const QPointF& to, Qt::MouseButtons buttons, Qt::KeyboardModifiers) {
        if (step_ != Exposure || exposure_->PlacingLandmarks()) return;
        if (exposure_->Tracing()) {
          if (stroke_.isEmpty()) stroke_ << from;
          if (QLineF(stroke_.last(), to).length() >= kTraceStep_px) stroke_ << to;
          view_->SetStroke(stroke_);
          return;
        }
        if (buttons & Qt::RightButton)
          desk_.Exposure()->Turn(ToVec(to - from));
        else
          desk_.Exposure()->Drag(ToVec(from), ToVec(to));
        changed();
      });
  connect(view_, &qKerfVideoView::Released, this, [=](const QPointF&, Qt::MouseButton) {
    if (step_ != Exposure || !exposure_->Tracing()) return;
    kerf::Pixels outline(stroke_.size(), 2);
    for (int i = 0; i < stroke_.size(); ++i) outline.row(i) << stroke_[i].x(), stroke_[i].y();
    desk_.Exposure()->Trace(outline);  // a mere click goes back to the outline by colour
    stroke_.clear();
    view_->SetStroke(stroke_);
    changed();
  });
  connect(view_, &qKerfVideoView::Turned, this, [=](double steps) {
    if (step_ != Exposure || exposure_->PlacingLandmarks() || exposure_->Tracing()) return;
    if (QGuiApplication::keyboardModifiers() & Qt::ShiftModifier)
      desk_.Exposure()->Roll(steps * kRollPerStep_deg);
    else
      desk_.Exposure()->Approach(std::pow(kApproachPerStep, steps));
    changed();
  });
}

/// On a copy, so that the window answers meanwhile; what the hand changed since wins.
void qKerfIntraoperativeWidget::FitOutline() {
  if (fitting_ || !desk_.Exposure()) return;
  fitting_ = true;
  const auto copy = std::make_shared<kerf::ExposureRegistration>(*desk_.Exposure());
  const Eigen::Isometry3d start = copy->Camera().camera_from_world;
  lamp_->setText(tr("Fitting the outline"));
  services_.run(
      tr("Fitting the outline"),
      [copy, frame = desk_.ExposureFrame()](kerf::Progress&) { copy->RefineByContour(frame); },
      [this, copy, start] {
        fitting_ = false;
        kerf::ExposureRegistration* exposure = desk_.Exposure();
        if (step_ != Exposure || !exposure ||
            exposure->Camera().camera_from_world.matrix() != start.matrix())
          return;
        *exposure = *copy;
        exposure_changed_ = true;
      },
      [this](const QString& problem) {
        fitting_ = false;
        exposure_changed_ = true;
        if (!problem.isEmpty()) services_.say_problem(problem);
      });
}

void qKerfIntraoperativeWidget::BeginExposure(bool fresh) {
  if (desk_.Running()) {
    EndRun([this, fresh] {
      desk_.KeepCutsForNextRun();
      BeginExposure(fresh);
    });
    return;
  }
  Try([&] {
    if (fresh) desk_.BeginExposure();
    shown_.reset();
    DrawAnew();
    ShowStep(Exposure);
    PaintExposure();
  });
}

void qKerfIntraoperativeWidget::PaintExposure() {
  exposure_changed_ = false;
  const kerf::ExposureRegistration* exposure = desk_.Exposure();
  if (!exposure) return;
  Try([&] {
    contour_fit_ = exposure->ContourFit(desk_.ExposureFrame());
    exposure_->Update(*exposure, contour_fit_);
    std::string why_not;
    if (!painter_ && kerf::RenderingAvailable(&why_not)) MakePainter(exposure->Camera());
    if (!painter_) {
      painter_problem_ =
          tr("No overlay can be drawn here: %1").arg(QString::fromStdString(why_not));
      services_.say_problem(painter_problem_);
      view_->SetPicture(*desk_.ExposureFrame().image);
      return;
    }
    kerf::OverlayOptions options;
    options.preset = kerf::OverlayPreset::Outline;
    options.show_legend = false;
    painter_->SetOptions(options);
    view_->SetPicture(painter_->PaintExposure(exposure->Camera(), desk_.ExposureFrame(),
                                              exposure->Organ(), desk_.Planned().structures));
  });
  QVector<qKerfVideoView::Marker> markers;
  for (const kerf::ExposureLandmark& landmark : exposure->Landmarks())
    if (landmark.pixel)
      markers.push_back({QPointF(landmark.pixel->x(), landmark.pixel->y()),
                         QString::fromStdString(landmark.name),
                         landmark.outlier    ? QColor(255, 110, 100)
                         : landmark.excluded ? QColor(170, 170, 170)
                                             : QColor(120, 255, 160),
                         landmark.excluded});
  view_->SetMarkers(markers);
  lamp_->setText(tr("Registration: not accepted yet"));
  ShowFigures(desk_.Source(), 0.0);
}

void qKerfIntraoperativeWidget::StartWithGivenPose() {
  BeginExposure(true);
  if (desk_.Exposure()) Accept();
}

void qKerfIntraoperativeWidget::Accept() {
  Try([&] {
    kerf::IntraoperativeDesk::RunOptions options;
    options.hold_cuts = run_->HoldsCuts();
    options.record = record_;
    options.deadline_ms = deadline_ms_;
    options.on_snapshot = [this] {
      QMetaObject::invokeMethod(this, &qKerfIntraoperativeWidget::Tick, Qt::QueuedConnection);
    };
    desk_.Accept(options);
    if (alarm_case_ != desk_.CaseFolder()) {  // once: then it is the surgeon's
      alarm_case_ = desk_.CaseFolder();
      look_->SetMarginAlarm(desk_.PlannedMargin_mm());
    }
    shown_.reset();
    shown_at_.Clear();
    stopped_.clear();
    not_recorded_.clear();
    painter_.reset();  // with the accepted camera
    SetOverlay(true);
    if (clamped_at_) desk_.Clamp(true);  // since the session before
    ShowStep(Run);
    services_.say(tr("Registration accepted."));
  });
}
