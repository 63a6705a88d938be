// What both a running and a recorded session show: overlay, lamp, figures, the state before a cut.
#include <QLabel>
#include <QScreen>
#include <QSplitter>
#include <cmath>

#include "Adapters/Rendering/VirtualDisplay.h"
#include "Common/qKerfTheme.h"
#include "Intraoperative/OverlayPainter.h"
#include "Intraoperative/qKerfIntraoperativeWidget.h"
#include "Intraoperative/qKerfOverlayLook.h"
#include "Intraoperative/qKerfRunPanel.h"
#include "Intraoperative/qKerfVideoView.h"

namespace {

using Clock = std::chrono::steady_clock;

// Of the strip's text, beside the panels; 16 pt at 96 dots per inch.
constexpr int kText_px = 21;
// With the picture alone, of the screen's height: capitals of 12 minutes of arc and more from two
// metres on a 24-inch screen (docs/tutorial/intraoperative.md).
constexpr int kTextsPerScreen = 29;

/// Qt lays a label out anew with every sheet, also with the one that it has.
void SetSheet(QLabel* label, const QString& sheet) {
  if (label->styleSheet() != sheet) label->setStyleSheet(sheet);
}

}  // namespace

void qKerfIntraoperativeWidget::ConnectLook() {
  connect(look_, &qKerfOverlayLook::PresetChanged, this, &qKerfIntraoperativeWidget::SetPreset);
  connect(look_, &qKerfOverlayLook::OpacityChanged, this, [this](double opacity) {
    ChangeLook([opacity](kerf::OverlayOptions* options) { options->organ_opacity = opacity; });
  });
  connect(look_, &qKerfOverlayLook::MarginAlarmChanged, this, [this](double mm) {
    if (painter_) painter_->SetMarginAlarm(mm);
    DrawAgain();
  });
  connect(look_, &qKerfOverlayLook::OverlayToggled, this, &qKerfIntraoperativeWidget::SetOverlay);
  connect(look_, &qKerfOverlayLook::BeforeToggled, this, &qKerfIntraoperativeWidget::SetBefore);
  connect(view_, &qKerfVideoView::Pressed, this, [this](const QPointF& at, Qt::MouseButton button) {
    if (button != Qt::LeftButton || drawing_ ||
        look_options_.preset != kerf::OverlayPreset::SeeThrough)
      return;
    if (step_ != Run && step_ != Review) return;
    ChangeLook([at](kerf::OverlayOptions* options) {  // the window goes where one clicks
      options->window_px = kerf::Vec2(at.x(), at.y());
    });
  });
}

/// What is shown follows when it is drawn (TakePainted).
void qKerfIntraoperativeWidget::Draw(std::shared_ptr<const kerf::IntraoperativeSnapshot> snapshot,
                                     const kerf::CameraModel& camera) {
  drawn_ = std::move(snapshot);
  if (overlay_on_ && overlay_problem_.empty()) try {
      std::string why_not;
      if (painter_ || kerf::RenderingAvailable(&why_not)) {
        if (!painter_) {
          MakePainter(camera);
          painter_->SetMarginAlarm(look_->MarginAlarm_mm());
          painter_->SetOptions(look_options_);
        }
        painter_->Begin(drawn_);
        return;
      }
      OverlayFails(why_not);
    } catch (const std::exception& error) {
      painter_.reset();
      OverlayFails(error.what());
    }
  if (step_ != Run && drawn_->frame.image) view_->SetPicture(*drawn_->frame.image);
  Present(drawn_);
}

void qKerfIntraoperativeWidget::MakePainter(const kerf::CameraModel& camera) {
  painter_ = std::make_unique<kerf::OverlayPainter>(camera, [this] {
    QMetaObject::invokeMethod(this, &qKerfIntraoperativeWidget::Tick, Qt::QueuedConnection);
  });
}

void qKerfIntraoperativeWidget::TakePainted() {
  if (!painter_) return;
  try {
    auto painted = painter_->Take();
    if (!painted) return;
    view_->SetPicture(painted->picture);
    Present(std::move(painted->snapshot));
  } catch (const std::exception& error) {
    painter_.reset();
    OverlayFails(error.what());
    drawn_.reset();
  }
}

/// What goes with the picture that is in the view now.
void qKerfIntraoperativeWidget::Present(
    std::shared_ptr<const kerf::IntraoperativeSnapshot> snapshot) {
  shown_ = std::move(snapshot);
  if (step_ != Run && raw_->isVisible() && shown_->frame.image)
    raw_->SetPicture(*shown_->frame.image);
  Try([this] { ShowBefore(); });
  ShowLamp(*shown_);
  ArrangeViews();
  if (step_ == Run && !Bare()) NoteShown(shown_->captured);
}

void qKerfIntraoperativeWidget::NoteShown(Clock::time_point captured) {
  if (shown_picture_ == captured) return;
  const auto now = Clock::now();
  shown_picture_ = captured;
  shown_at_.Add(now);
  latency_ms_ = std::chrono::duration<double, std::milli>(now - captured).count();
}

/// In a new look. What is in work is still shown: while a slider is dragged nothing else would be.
void qKerfIntraoperativeWidget::DrawAgain() {
  drawn_.reset();
  before_shown_.reset();
  newest_shown_ = {};
}

/// The picture that is in work is of a camera or a step that is no longer; the newest one is drawn
/// again.
void qKerfIntraoperativeWidget::DrawAnew() {
  if (painter_) painter_->Forget();
  DrawAgain();
}

/// Views stand side by side or one above the other, whichever makes the pictures larger.
void qKerfIntraoperativeWidget::ArrangeViews() {
  const QSize picture = view_->Picture().size();
  int shown = 0;
  for (QWidget* view : {view_, before_, raw_}) shown += !view->isHidden();
  if (picture.isEmpty() || shown < 2) return;
  const auto scale = [&](int columns, int rows) {
    return qMin(double(views_->width()) / columns / picture.width(),
                double(views_->height()) / rows / picture.height());
  };
  const auto better = scale(1, shown) > scale(shown, 1) ? Qt::Vertical : Qt::Horizontal;
  if (views_->orientation() == better) return;
  views_->setOrientation(better);
  views_->setSizes(QList<int>({1000, 1000, 1000}));
}

/// The picture goes on without the overlay.
void qKerfIntraoperativeWidget::OverlayFails(const std::string& why) {
  view_->SetBanner(tr("NO OVERLAY"), QColor(179, 38, 30, 200));
  overlay_problem_ = why;
  newest_shown_ = {};
  services_.say_problem(tr("No overlay can be drawn: %1. Switch it off and on (O) to try again.")
                            .arg(QString::fromStdString(why)));
}

void qKerfIntraoperativeWidget::ShowBefore() {
  const kerf::CutItem* cut = nullptr;
  if (before_on_ && shown_) {
    const int selected = step_ == Run ? run_->CurrentCut(*shown_, false) : -1;
    for (const kerf::CutItem& item : shown_->cuts)
      if (item.before && (!cut || cut->number != selected)) cut = &item;
  }
  before_->setVisible(cut != nullptr);
  if (!cut) {
    before_shown_.reset();
    return;
  }
  if (before_shown_ == cut->before) return;
  before_shown_ = cut->before;
  if (painter_ && overlay_on_)
    before_->SetPicture(painter_->Paint(*before_shown_));
  else if (before_shown_->frame.image)
    before_->SetPicture(*before_shown_->frame.image);
  before_->SetBanner(  // opaque: the overlay's legend is behind it
      tr("BEFORE CUT %1 · %2 s").arg(cut->number + 1).arg(before_shown_->frame.time_s, 0, 'f', 2),
      Qt::black);
}

void qKerfIntraoperativeWidget::SetBefore(bool before) {
  before_on_ = before;
  look_->SetBefore(before);
  before_shown_.reset();
  Try([this] { ShowBefore(); });
}

void qKerfIntraoperativeWidget::ChangeLook(
    const std::function<void(kerf::OverlayOptions*)>& change) {
  change(&look_options_);
  if (step_ != Run && step_ != Review) return;  // the exposure has a look of its own
  if (painter_) painter_->SetOptions(look_options_);
  DrawAgain();
}

void qKerfIntraoperativeWidget::SetPreset(kerf::OverlayPreset preset) {
  look_->SetPreset(preset);
  ChangeLook([preset](kerf::OverlayOptions* options) {
    options->preset = preset;
    options->window_px.reset();
  });
}

void qKerfIntraoperativeWidget::SetOverlay(bool on) {
  overlay_on_ = on;
  overlay_problem_.clear();
  look_->SetOverlay(on);
  view_->SetBanner(on ? QString() : tr("OVERLAY OFF  (O)"));
  DrawAnew();
}

void qKerfIntraoperativeWidget::ShowLamp(const kerf::IntraoperativeSnapshot& snapshot) {
  const bool green = snapshot.gate == kerf::GateState::Green;
  const bool amber = snapshot.gate == kerf::GateState::Amber;
  QString text = green ? tr("OVERLAY OK") : amber ? tr("CAUTION") : tr("OVERLAY OFF");
  if (!green) text += ": " + QString::fromStdString(snapshot.reason).toHtmlEscaped();
  if (std::isfinite(snapshot.reliability.tumour_u95_mm) && snapshot.gate != kerf::GateState::Off)
    text += tr("<br>tumour ± %1 mm").arg(snapshot.reliability.tumour_u95_mm, 0, 'f', 1);
  lamp_->setText(text);
  SetSheet(lamp_, QString("font-size: %3px; font-weight: bold; padding: 4px; color: %1; "
                          "background: %2;")
                      .arg(amber ? "black" : "white", green   ? "#1f7a3d"
                                                      : amber ? "#ffbe3c"
                                                              : "#b3261e")
                      .arg(StripText_px()));
  QStringList distances;
  if (std::isfinite(snapshot.margin_mm))
    distances << tr("tumour&nbsp;–&nbsp;cut %1&nbsp;mm").arg(snapshot.margin_mm, 0, 'f', 1);
  if (std::isfinite(snapshot.deviation.mean_mm))
    distances << tr("<span style='font-size:%3px'>plan – cut %1 mm, at most %2</span>")
                     .arg(snapshot.deviation.mean_mm, 0, 'f', 1)
                     .arg(snapshot.deviation.max_mm, 0, 'f', 1)
                     .arg(full_ ? StripText_px() : 15);
  margin_->setText(distances.join("<br>"));
  SetSheet(margin_, QString("font-size: %1px; font-weight: bold; padding: 4px;%2")
                        .arg(full_ ? StripText_px() : 20)
                        .arg(snapshot.margin_mm < look_->MarginAlarm_mm()
                                 ? " color: white; background: #b3261e;"
                                 : ""));
}

void qKerfIntraoperativeWidget::ShowFigures(const kerf::SourceState& source, double registered_fps,
                                            bool not_recorded) {
  QString text;
  if (not_recorded)  // in the strip, which stays when the picture is alone
    text = tr("<span style='font-size: %2px; font-weight: bold; color: %1'>NOT RECORDED</span>")
               .arg(qKerfTheme::Current().problem.name())
               .arg(StripText_px());
  if (full_) {  // rates are for whoever sits at the panels
    figures_->setText(text);
    return;
  }
  if (not_recorded) text += "<br>";
  text += tr("video %1/s").arg(source.fps, 0, 'f', 0);
  if (registered_fps > 0)
    text += tr(" · registered %1/s<br>shown %2/s · latency %3 ms<br>dropped %4")
                .arg(registered_fps, 0, 'f', 0)
                .arg(ShownPerSecond(), 0, 'f', 0)
                .arg(latency_ms_, 0, 'f', 0)
                .arg(source.dropped);
  figures_->setText(text);
}

int qKerfIntraoperativeWidget::StripText_px() const {
  return full_ ? qMax(kText_px, screen()->size().height() / kTextsPerScreen) : kText_px;
}

/// Three lines: a longer reason does not move the picture.
void qKerfIntraoperativeWidget::ArrangeStrip() { lamp_->setMinimumHeight(4 * StripText_px()); }

double qKerfIntraoperativeWidget::ShownPerSecond() const {
  return shown_at_.PerSecond(Clock::now());
}

void qKerfIntraoperativeWidget::SetRawBeside(bool beside) {
  raw_->setVisible(beside);
  newest_shown_ = {};  // in a session: with the next tick
  if (beside && shown_ && shown_->frame.image) raw_->SetPicture(*shown_->frame.image);
  ArrangeViews();
}

/// The picture alone; back to a window that filled the screen before, or did not.
void qKerfIntraoperativeWidget::SetFullScreen(bool full) {
  if (full == full_) return;
  full_ = full;
  side_->setVisible(!full);
  ArrangeStrip();
  if (shown_) ShowLamp(*shown_);
  figures_at_ = {};  // with the next tick
  QWidget* top = window();
  if (full) was_full_screen_ = top->isFullScreen();
  top->setWindowState(full || was_full_screen_ ? top->windowState() | Qt::WindowFullScreen
                                               : top->windowState() & ~Qt::WindowFullScreen);
}
