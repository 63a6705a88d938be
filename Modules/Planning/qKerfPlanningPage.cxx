#include "qKerfPlanningPage.h"

#include <QComboBox>
#include <QFileInfo>
#include <QFrame>
#include <QHBoxLayout>
#include <QLabel>
#include <QMessageBox>
#include <QPushButton>
#include <QScrollArea>
#include <QStackedWidget>
#include <QTimer>
#include <QToolButton>
#include <QVBoxLayout>
#include <QVariant>

#include "Framework/qKerfHost.h"
#include "Framework/qKerfJobRunner.h"
#include "Planning/qKerfCameraPanel.h"
#include "Planning/qKerfImportPanel.h"
#include "Planning/qKerfMeshPanel.h"
#include "Planning/qKerfPlanPanel.h"
#include "Planning/qKerfSavePanel.h"
#include "Planning/qKerfSegmentPanel.h"
#include "Planning/qKerfSeriesTable.h"
#include "Planning/qKerfStepList.h"
#include "PlanningJobs.h"
#include "PlanningMouse.h"
#include "PlanningRecovery.h"
#include "PlanningViews.h"
#include "Session/PlanningSlice.h"
#include "Session/UndoStack.h"
#include "Views/qKerfSceneView.h"
#include "Views/qKerfSliceView.h"

using kerf::PlanningChange;
using kerf::PlanningStep;
using Tool = qKerfSegmentPanel::Tool;

qKerfPlanningPage::qKerfPlanningPage(qKerfHost* host, QWidget* parent)
    : QWidget(parent),
      host_(host),
      session_(new kerf::PlanningSession(host->Undo())),
      views_(new PlanningViews(*session_, this)),
      jobs_(new PlanningJobs(host, *session_, this)),
      recovery_(new PlanningRecovery(host, *session_, this)) {
  setObjectName("planningPage");
  MakeLayout();
  mouse_ =
      new PlanningMouse({host_, session_.get(), views_, jobs_, segment_, plan_, camera_}, this);
  session_->SetListener([this](PlanningChange change) { Listen(change); });
  jobs_->AskBeforeReplacing([this](const QString& question) { return MayDropWork(question); });
  WireImport();
  WireSegment();
  WireRest();
  MakeShortcuts();
  connect(steps_, &qKerfStepList::StepChosen, this, &qKerfPlanningPage::StepChosen);
  connect(host_, &qKerfHost::ThemeChanged, this, [this] {
    views_->Scene()->ApplyTheme();
    RefreshPanels();
  });
  views_->ShowVolume();
  RefreshPanels();
}

qKerfPlanningPage::~qKerfPlanningPage() {
  session_->SetListener({});
  host_->Undo().Clear();  // its steps know the session
}

void qKerfPlanningPage::MakeLayout() {
  steps_ = new qKerfStepList;
  panels_ = new QStackedWidget;
  const auto add = [this](QWidget* panel) {
    auto* scroll = new QScrollArea;
    scroll->setWidget(panel);
    scroll->setWidgetResizable(true);
    scroll->setHorizontalScrollBarPolicy(Qt::ScrollBarAlwaysOff);
    scroll->setFrameShape(QFrame::NoFrame);
    panels_->addWidget(scroll);
  };
  add(import_ = new qKerfImportPanel);
  add(segment_ = new qKerfSegmentPanel);
  add(mesh_ = new qKerfMeshPanel);
  add(plan_ = new qKerfPlanPanel);
  add(camera_ = new qKerfCameraPanel);
  add(save_ = new qKerfSavePanel);
  auto* line = new QFrame;
  line->setProperty("role", "line");
  auto* side = new QWidget;
  side->setFixedWidth(336);
  auto* column = new QVBoxLayout(side);
  column->setContentsMargins(8, 8, 2, 4);
  column->setSpacing(6);
  column->addWidget(steps_);
  column->addWidget(line);
  column->addWidget(panels_, 1);

  MakeRecoveryBar();
  auto* right = new QVBoxLayout;
  right->setContentsMargins(0, 4, 4, 4);
  right->setSpacing(4);
  right->addWidget(recovery_bar_);
  right->addWidget(series_ = new qKerfSeriesTable);
  right->addWidget(MakeViewBar());
  right->addWidget(views_->Widget(), 1);
  auto* row = new QHBoxLayout(this);
  row->setContentsMargins(0, 0, 0, 0);
  row->setSpacing(4);
  row->addWidget(side);
  row->addLayout(right, 1);
}

QWidget* qKerfPlanningPage::MakeViewBar() {
  auto* bar = new QWidget;
  auto* row = new QHBoxLayout(bar);
  row->setContentsMargins(2, 0, 2, 0);
  window_ = new QComboBox;
  window_->setObjectName("windowChoice");
  for (const kerf::WindowPreset& p : kerf::WindowPresets())
    window_->addItem(QString::fromStdString(p.name));
  window_->setToolTip(tr("Window and level of the slices; or drag with the right button"));
  row->addWidget(new QLabel(tr("Window")));
  row->addWidget(window_);
  row->addSpacing(12);
  row->addWidget(new QLabel(tr("3-D from")));
  for (const char side : {'A', 'P', 'R', 'L', 'S', 'I'}) {
    auto* button = new QToolButton;
    button->setText(QString(QChar(side)));
    button->setObjectName(QStringLiteral("lookFrom%1").arg(QChar(side)));
    button->setToolTip(tr("Look at the 3-D view from this side of the patient"));
    connect(button, &QToolButton::clicked, this, [this, side] { views_->Scene()->LookFrom(side); });
    row->addWidget(button);
  }
  row->addStretch(1);
  auto* hint = new QLabel(tr("Wheel: slices · Ctrl+wheel: zoom · right drag: window"));
  hint->setToolTip(
      tr("Middle drag moves a slice; a double click shows one view on the whole page; "
         "arrow keys go through the slices"));
  hint->setProperty("role", "faint");
  hint->setSizePolicy(QSizePolicy::Ignored, QSizePolicy::Preferred);
  hint->setAlignment(Qt::AlignRight | Qt::AlignVCenter);
  row->addWidget(hint, 10);
  connect(window_, QOverload<int>::of(&QComboBox::activated), this, [this](int index) {
    const kerf::WindowPreset& p = kerf::WindowPresets()[index];
    views_->SetWindowLevel(p.window_hu, p.level_hu);
  });
  return bar;
}

void qKerfPlanningPage::MakeRecoveryBar() {
  recovery_bar_ = new QFrame;
  recovery_bar_->setObjectName("recoveryBar");
  recovery_bar_->setProperty("role", "panel");
  recovery_text_ = new QLabel;
  recovery_text_->setObjectName("recoveryText");
  auto* recover = new QPushButton(tr("Recover the work"));
  recover->setObjectName("recoverButton");
  recover->setProperty("primary", true);
  auto* discard = new QPushButton(tr("Discard"));
  discard->setObjectName("discardButton");
  auto* row = new QHBoxLayout(recovery_bar_);
  row->setContentsMargins(10, 6, 6, 6);
  row->addWidget(recovery_text_, 1);
  row->addWidget(recover);
  row->addWidget(discard);
  ShowLeftWork();
  // After the work was read its CT is opened: only then, or where reading failed, may it be tried
  // again.
  connect(&host_->Jobs(), &qKerfJobRunner::Finished, recovery_bar_,
          [this](const QString& title, const QString& sentence, bool cancelled) {
            if (title != PlanningJobs::RecoverTitle() || !sentence.isEmpty() || cancelled)
              recovery_bar_->setEnabled(true);
          });
  connect(recover, &QPushButton::clicked, this, &qKerfPlanningPage::Recover);
  connect(discard, &QPushButton::clicked, this, [this] {
    recovery_->Discard();
    ShowLeftWork();
  });
}

void qKerfPlanningPage::ShowLeftWork() {
  QString text;
  recovery_bar_->setVisible(recovery_->HasLeftWork(&text));
  recovery_text_->setText(text);
}

void qKerfPlanningPage::Listen(PlanningChange change) {
  switch (change) {
    case PlanningChange::Volume:
      recovery_->Forget();  // what this takes the place of is saved, or was given up
      views_->ShowVolume();
      break;
    case PlanningChange::Labels:
      // The mesh of other labels is not shown, and comes back when the edit is undone.
      if (!mouse_->Stroking() && session_->Model()) ShowModel();
      views_->ShowLabels();
      break;
    case PlanningChange::LabelList:
      views_->ShowLabelList();
      break;
    case PlanningChange::Seeds:
    case PlanningChange::Landmarks:
      views_->ShowMarkers();
      break;
    case PlanningChange::Plan:
      views_->ShowMarkers();
      ShowModel();
      break;
    case PlanningChange::Model:
      ShowModel();
      break;
    default:
      break;
  }
  recovery_->Touched();
  // Many changes in one turn (every dab of a stroke) are one look at the panels.
  if (refresh_waits_) return;
  refresh_waits_ = true;
  QTimer::singleShot(mouse_->Stroking() ? 150 : 0, this, [this] {
    refresh_waits_ = false;
    RefreshPanels();
  });
}

void qKerfPlanningPage::RefreshPanels() {
  steps_->Show(*session_);
  import_->Show(*session_);
  segment_->Show(*session_);
  mesh_->Show(*session_);
  plan_->Show(*session_);
  camera_->Show(*session_);
  save_->Show(*session_);
}

void qKerfPlanningPage::ShowModel() {
  const bool on_mesh = steps_->Current() == static_cast<int>(PlanningStep::Mesh);
  const bool on_plan = steps_->Current() == static_cast<int>(PlanningStep::Plan);
  views_->ShowModel(on_mesh && mesh_->QualityShown(), on_plan && plan_->SheetColored(),
                    on_plan && plan_->OrganColored());
}

void qKerfPlanningPage::StepChosen(int step) {
  panels_->setCurrentIndex(step);
  if (step != static_cast<int>(PlanningStep::Plan)) plan_->StopDrawing();
  if (step != static_cast<int>(PlanningStep::Camera)) camera_->StopPlacing();
  if (step != static_cast<int>(PlanningStep::Segment)) segment_->SetTool(Tool::Look);
  views_->ShowMargin(step == static_cast<int>(PlanningStep::Plan));
  if (session_->Model()) ShowModel();
}

void qKerfPlanningPage::OpenCt(const QString& path) {
  host_->ShowModule("planning");
  jobs_->Open(path, {});
}

bool qKerfPlanningPage::OpenCase(const QString& folder) {
  // The case that was just saved here is open already.
  if (QFileInfo(folder) == QFileInfo(QString::fromStdString(session_->CaseFolderPath())) &&
      !session_->IsDirty())
    return true;
  jobs_->OpenCase(folder);
  return true;
}

void qKerfPlanningPage::Recover() {
  recovery_bar_->setEnabled(false);  // once is enough, until the job of opening the CT is over, too
  jobs_->Recover(recovery_->LeftFile(), [this] {
    recovery_->Recovered();
    ShowLeftWork();
    steps_->SetCurrent(static_cast<int>(PlanningStep::Segment));
    host_->Say(qKerfHost::Info, tr("The work is back. Make the mesh again (step 3)."));
  });
}

bool qKerfPlanningPage::MayDropWork(const QString& question) {
  if (!session_->IsDirty()) return true;
  const QString changes = tr("The planning has changes that no case holds.");
  const auto answer =
      QMessageBox::question(this, tr("Unsaved work"), changes + ' ' + question,
                            QMessageBox::Discard | QMessageBox::Cancel, QMessageBox::Cancel);
  return answer == QMessageBox::Discard;
}

bool qKerfPlanningPage::CanLeaveCase() {
  return MayDropWork(tr("Open the case without saving them?"));
}

bool qKerfPlanningPage::CanClose() {
  if (!MayDropWork(tr("Close without saving them?"))) return false;
  recovery_->Forget();
  return true;
}
