#include "Intraoperative/qKerfIntraoperativeWidget.h"

#include <QAction>
#include <QHBoxLayout>
#include <QLabel>
#include <QListWidget>
#include <QPushButton>
#include <QShowEvent>
#include <QSplitter>
#include <QStackedWidget>
#include <QVBoxLayout>
#include <cmath>

#include "Intraoperative/OverlayPainter.h"
#include "Intraoperative/qKerfCheckInPanel.h"
#include "Intraoperative/qKerfExposurePanel.h"
#include "Intraoperative/qKerfOverlayLook.h"
#include "Intraoperative/qKerfReviewPanel.h"
#include "Intraoperative/qKerfRunPanel.h"
#include "Intraoperative/qKerfTimeline.h"
#include "Intraoperative/qKerfVideoView.h"
#include "Pipelines/SessionPlayback.h"

namespace {

constexpr int kTick_ms = 8;
constexpr int kSide_px = 380;

}  // namespace

qKerfIntraoperativeWidget::qKerfIntraoperativeWidget(Services services, QWidget* parent)
    : QWidget(parent), services_(std::move(services)) {
  setObjectName("intraoperativePage");
  if (!services_.run)
    services_.run = [](const QString&, auto work, auto done, auto failed) {
      kerf::Progress silent;
      try {
        work(silent);
        if (done) done();
      } catch (const std::exception& error) {
        if (failed) failed(QString::fromUtf8(error.what()));
      }
    };
  if (!services_.say) services_.say = [](const QString&) {};
  if (!services_.say_problem) services_.say_problem = services_.say;
  MakeLayout();
  MakeKeys();
  ConnectCheckIn();
  ConnectExposure();
  ConnectRun();
  ConnectReview();
  ConnectLook();
  ShowStep(CheckIn);
  connect(&timer_, &QTimer::timeout, this, &qKerfIntraoperativeWidget::Tick);
  timer_.start(kTick_ms);
}

qKerfIntraoperativeWidget::~qKerfIntraoperativeWidget() {
  timer_.stop();
  StopNow();
}

void qKerfIntraoperativeWidget::StopNow() {
  if (ending_.valid()) ending_.wait();
  desk_.Stop();
}

void qKerfIntraoperativeWidget::MakeLayout() {
  auto* layout = new QHBoxLayout(this);
  layout->setContentsMargins(6, 6, 6, 6);
  side_ = new QWidget;
  side_->setFixedWidth(kSide_px);
  auto* side = new QVBoxLayout(side_);
  side->setContentsMargins(0, 0, 0, 0);
  auto* row = new QHBoxLayout;
  const QString names[] = {tr("1 Check-in"), tr("2 Register"), tr("3 Run"), tr("4 Close")};
  for (int i = 0; i < 4; ++i) {
    steps_[i] = new QPushButton(names[i]);
    steps_[i]->setCheckable(true);
    steps_[i]->setFocusPolicy(Qt::NoFocus);
    steps_[i]->setObjectName(QString("step%1").arg(i + 1));
    row->addWidget(steps_[i]);
  }
  side->addLayout(row);
  side->addWidget(look_ = new qKerfOverlayLook);
  pages_ = new QStackedWidget;
  pages_->addWidget(check_in_ = new qKerfCheckInPanel);
  pages_->addWidget(exposure_ = new qKerfExposurePanel);
  pages_->addWidget(run_ = new qKerfRunPanel);
  close_ = new QWidget;
  auto* close = new QVBoxLayout(close_);
  close_text_ = new QLabel;
  close_text_->setObjectName("close_text");
  close_text_->setWordWrap(true);
  close_text_->setTextInteractionFlags(Qt::TextSelectableByMouse);
  close->addWidget(close_text_);
  export_ = new QPushButton(tr("Export all meshes and the report"));
  export_->setObjectName("export");
  export_->setMinimumHeight(44);
  close->addWidget(export_);
  play_session_ = new QPushButton(tr("Play the session"));
  play_session_->setObjectName("play_session");
  close->addWidget(play_session_);
  exported_ = new QListWidget;
  exported_->setObjectName("exported");
  close->addWidget(exported_, 1);
  pages_->addWidget(close_);
  pages_->addWidget(review_ = new qKerfReviewPanel);
  side->addWidget(pages_, 1);
  layout->addWidget(side_);

  auto* right = new QVBoxLayout;
  views_ = new QSplitter(Qt::Horizontal);
  view_ = new qKerfVideoView;
  view_->setObjectName("overlay_view");
  view_->setFocusPolicy(Qt::StrongFocus);
  raw_ = new qKerfVideoView;
  raw_->setObjectName("raw_view");
  raw_->SetBanner(tr("RAW VIDEO"));
  raw_->hide();
  before_ = new qKerfVideoView;
  before_->setObjectName("before_view");
  before_->hide();
  for (auto* view : {view_, before_, raw_}) views_->addWidget(view);
  right->addWidget(views_, 1);
  right->addWidget(timeline_ = new qKerfTimeline);
  auto* strip = new QHBoxLayout;
  lamp_ = new QLabel;
  lamp_->setObjectName("lamp");
  // Wrapped, so that no figure makes the window wider than the screen.
  lamp_->setMinimumWidth(280);
  ArrangeStrip();
  margin_ = new QLabel;
  margin_->setObjectName("margin");
  margin_->setAlignment(Qt::AlignCenter);
  margin_->setTextFormat(Qt::RichText);
  figures_ = new QLabel;
  figures_->setObjectName("figures");
  figures_->setAlignment(Qt::AlignRight | Qt::AlignVCenter);
  figures_->setStyleSheet("font-size: 11pt;");
  for (QLabel* label : {lamp_, margin_, figures_}) label->setWordWrap(true);
  margin_->setMinimumWidth(230);
  figures_->setMinimumWidth(200);
  strip->addWidget(lamp_, 4);
  strip->addWidget(margin_, 3);
  strip->addWidget(figures_, 3);
  right->addLayout(strip);
  layout->addLayout(right, 1);

  for (int i = 0; i < 4; ++i)
    connect(steps_[i], &QPushButton::clicked, this, [this, i] {
      // Forward only through what each step asks for; back to the check-in only without a session.
      if (i == CheckIn && !desk_.Running()) ShowStep(CheckIn);
      if (i == Exposure && step_ == Run) BeginExposure(true);
      for (int k = 0; k < 4; ++k) steps_[k]->setChecked(k == step_);
    });
  connect(export_, &QPushButton::clicked, this, &qKerfIntraoperativeWidget::ExportAll);
}

void qKerfIntraoperativeWidget::MakeKeys() {
  const auto key = [this](const char* id, const QString& text, const QKeySequence& keys,
                          std::function<void()> act) {
    auto* action = new QAction(text, this);
    action->setObjectName(id);
    action->setShortcut(keys);
    action->setShortcutContext(Qt::WidgetWithChildrenShortcut);
    connect(action, &QAction::triggered, this, std::move(act));
    addAction(action);
    if (services_.add_shortcut) services_.add_shortcut(QString("intraoperative/") + id, action);
  };
  using Kind = kerf::IntraoperativeDecision::Kind;
  using Preset = kerf::OverlayPreset;
  key("overlay", tr("Overlay on and off"), Qt::Key_O, [this] { SetOverlay(!overlay_on_); });
  key("fullscreen", tr("Picture alone"), Qt::Key_F, [this] { SetFullScreen(!full_); });
  key("raw", tr("Raw video beside"), Qt::Key_B, [this] { SetRawBeside(raw_->isHidden()); });
  key("outline", tr("Outline"), Qt::Key_1, [this] { SetPreset(Preset::Outline); });
  key("see-through", tr("See-through"), Qt::Key_2, [this] { SetPreset(Preset::SeeThrough); });
  key("full", tr("Full overlay"), Qt::Key_3, [this] { SetPreset(Preset::Full); });
  key("accept", tr("Accept the cut"), Qt::Key_A, [this] { DecideOnCut(true); });
  key("reject", tr("Reject the cut"), Qt::Key_R, [this] { DecideOnCut(false); });
  key("undo", tr("Undo the last decision"), Qt::Key_Z, [this] {
    if (step_ == Run) Post(Kind::Undo);
  });
  key("draw", tr("Draw a cut"), Qt::Key_D, [this] { SetDrawing(!drawing_); });
  key("confirm", tr("Confirm the registration"), Qt::Key_C, [this] {
    if (step_ == Run) Post(Kind::Confirm);
  });
  key("snapshot", tr("Keep a snapshot"), Qt::Key_S, [this] { KeepSnapshot(); });
  key("mark", tr("Set a mark"), Qt::Key_M, [this] {
    desk_.Mark("key");
    services_.say(tr("Marked."));
  });
  key("clamp", tr("Clamp closed and open"), Qt::Key_K, [this] { SetClamp(!clamped_at_); });
  key("before", tr("Before the cut, beside"), Qt::Key_V, [this] { SetBefore(!before_on_); });
  key("play", tr("Play a recorded session"), Qt::Key_Space, [this] { SetPlaying(!playing_); });
  key("back", tr("One picture back"), Qt::Key_Left, [this] { SeekTo(review_frame_ - 1); });
  key("on", tr("One picture on"), Qt::Key_Right, [this] { SeekTo(review_frame_ + 1); });
}

void qKerfIntraoperativeWidget::Try(const std::function<void()>& work) {
  try {
    work();
  } catch (const std::exception& error) {
    services_.say_problem(QString::fromUtf8(error.what()));
    lamp_->setText(QString::fromUtf8(error.what()).toHtmlEscaped());
  }
}

void qKerfIntraoperativeWidget::ConnectCheckIn() {
  connect(check_in_, &qKerfCheckInPanel::SourceWanted, this,
          &qKerfIntraoperativeWidget::OpenSource);
  connect(check_in_, &qKerfCheckInPanel::CameraWanted, this, &qKerfIntraoperativeWidget::UseCamera);
  connect(check_in_, &qKerfCheckInPanel::ConfirmedChanged, this,
          &qKerfIntraoperativeWidget::TickCheckIn);
  connect(check_in_, &qKerfCheckInPanel::GoOn, this, [this] { BeginExposure(true); });
  connect(check_in_, &qKerfCheckInPanel::ResumeWanted, this, [this](const QString& session) {
    if (!desk_.MayRegister(check_in_->Confirmed().toStdString())) {
      services_.say_problem(tr("First the check-in: case number, pictures and camera file."));
      return;
    }
    Try([&] {
      const int cuts = desk_.Resume(session.toStdString());
      services_.say(tr("Pose and %n cut(s) are taken over. Check the registration.", "", cuts));
      BeginExposure(false);
    });
  });
}

void qKerfIntraoperativeWidget::OpenCase(const QString& folder) {
  auto planned = std::make_shared<std::shared_ptr<const kerf::PlannedCase>>();
  services_.run(
      tr("Opening the case"),
      [planned, path = folder.toStdString()](kerf::Progress&) {
        *planned = kerf::IntraoperativeDesk::ReadPlanned(path);
      },
      [this, planned, folder] {
        Try([&] {
          desk_.OpenCase(folder.toStdString(), *planned);
          check_in_->SetCase(folder, QString::fromStdString(desk_.Pseudonym()));
          check_in_->SetCamera(QString::fromStdString(desk_.CameraFile()));
          shown_.reset();
          DrawAnew();
          clamped_at_.reset();  // another patient
          clamped_before_ = {};
          ShowClamp();
          ShowStep(CheckIn);
          emit CaseOpened(folder);
        });
      },
      [this](const QString& problem) {
        if (!problem.isEmpty()) services_.say_problem(problem);
      });
}

void qKerfIntraoperativeWidget::OpenSource(const QString& path) {
  check_in_->SetSource(path);
  shown_.reset();
  DrawAnew();
  desk_.OpenSource(path.toStdString());
  if (step_ != CheckIn) ShowStep(CheckIn);
}

void qKerfIntraoperativeWidget::UseCamera(const QString& file) {
  Try([&] {
    desk_.UseCamera(file.toStdString());
    painter_.reset();
  });
  // Where the file is no calibration, the one before it stays.
  check_in_->SetCamera(QString::fromStdString(desk_.CameraFile()));
}

qKerfIntraoperativeWidget::Step qKerfIntraoperativeWidget::CurrentStep() const { return step_; }

/// From another module: the page's keys work at once, without a click.
void qKerfIntraoperativeWidget::showEvent(QShowEvent* event) {
  QWidget::showEvent(event);
  if (event->spontaneous()) return;  // a window that is restored keeps its focus
  view_->setFocus();
}

/// The views of the module that is shown now draw with the same font engine.
void qKerfIntraoperativeWidget::hideEvent(QHideEvent* event) {
  QWidget::hideEvent(event);
  if (painter_) painter_->Rest();
  DrawAnew();
}

void qKerfIntraoperativeWidget::ShowStep(Step step) {
  step_ = step;
  pages_->setCurrentIndex(step);
  for (int i = 0; i < 4; ++i) {
    steps_[i]->setChecked(i == step);
    steps_[i]->setEnabled(i == step || (i == CheckIn && !desk_.Running()) ||
                          (i == Exposure && step == Run));
  }
  const bool overlay = step == Run || step == Review;
  look_->setVisible(overlay);
  timeline_->setVisible(step == Review);
  if (!overlay) before_->hide();
  if (step != Review) {
    playing_ = false;
    playback_.reset();
  }
  if (step == CheckIn && desk_.HasCase()) {
    check_in_->OfferResume(desk_.Unfinished());
    check_in_->OfferRecorded(desk_.Recorded());
  }
  SetDrawing(false);
  view_->SetMarkers({});
  if (!overlay) view_->SetBanner(QString());
  if (step != Run) {
    margin_->clear();
    figures_->clear();
    lamp_->setStyleSheet("font-size: 16pt; font-weight: bold; padding: 4px;");
  }
  view_->setFocus();
  emit StepChanged(step);
}

void qKerfIntraoperativeWidget::Tick() {
  if (ending_.valid()) return TickEnd();  // what is shown stays until the session is complete
  switch (step_) {
    case CheckIn:
      TickCheckIn();
      break;
    case Exposure:
      if (exposure_changed_) PaintExposure();
      break;
    case Run:
      TickRun();
      break;
    case Close:
      break;
    case Review:
      TickReview();
      break;
  }
}

void qKerfIntraoperativeWidget::TickCheckIn() {
  const std::string confirmed = check_in_->Confirmed().toStdString();
  check_in_->SetItems(desk_.CheckIn(confirmed), desk_.MayRegister(confirmed));
  const auto newest = desk_.Newest();
  if (newest && newest->captured != shown_picture_ && newest->frame.image) {
    shown_picture_ = newest->captured;
    view_->SetPicture(*newest->frame.image);
    view_->SetBanner(QString());
  }
  lamp_->setText(tr("Research use, not a medical device."));
  ShowFigures(desk_.Source(), 0.0);
}
