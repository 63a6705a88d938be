#include "qKerfPlanningPage.h"

#include <QAction>
#include <QComboBox>
#include <QDragEnterEvent>
#include <QFileInfo>
#include <QFrame>
#include <QHBoxLayout>
#include <QLabel>
#include <QMessageBox>
#include <QMimeData>
#include <QPushButton>
#include <QScrollArea>
#include <QScrollBar>
#include <QStackedWidget>
#include <QTimer>
#include <QToolButton>
#include <QVBoxLayout>
#include <QVariant>
#include <cmath>
#include <functional>

#include "Adapters/OpenCv/CameraFile.h"
#include "Common/qKerfPaths.h"
#include "Core/Errors.h"
#include "Framework/qKerfHost.h"
#include "Framework/qKerfJobRunner.h"
#include "Geometry/SurfaceTree.h"
#include "Pipelines/PlanPipeline.h"
#include "Planning/qKerfCameraPanel.h"
#include "Planning/qKerfImportPanel.h"
#include "Planning/qKerfMeshPanel.h"
#include "Planning/qKerfPlanPanel.h"
#include "Planning/qKerfSavePanel.h"
#include "Planning/qKerfSegmentPanel.h"
#include "Planning/qKerfStepList.h"
#include "PlanningJobs.h"
#include "PlanningRecovery.h"
#include "PlanningViews.h"
#include "Session/PlanningAutosave.h"
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
  setAcceptDrops(true);
  MakeLayout();
  session_->SetListener([this](PlanningChange change) { Listen(change); });
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
  QString text;
  recovery_bar_->setVisible(recovery_->HasLeftWork(&text));
  recovery_text_->setText(text);
  connect(recover, &QPushButton::clicked, this, &qKerfPlanningPage::Recover);
  connect(discard, &QPushButton::clicked, this, [this] {
    recovery_->Forget();
    recovery_bar_->hide();
  });
}

void qKerfPlanningPage::WireImport() {
  connect(import_, &qKerfImportPanel::OpenWanted, this,
          [this](const QString& path, const QString& series) { jobs_->Open(path, series); });
  connect(jobs_, &PlanningJobs::SeriesFound, this, [this](const QString& folder) {
    QVector<qKerfImportPanel::Series> rows;
    for (const auto& s : jobs_->Series())
      rows.push_back({s.uid, s.description, s.modality, s.spacing, s.slices});
    import_->SetSeries(folder, rows);
    if (!rows.isEmpty()) steps_->SetCurrent(0);
  });
  connect(jobs_, &PlanningJobs::CaseOpened, this, [this](const QString& folder) {
    save_->SetFolder(folder);
    views_->Scene()->LookFrom('A');
    ShowModel();
    steps_->SetCurrent(static_cast<int>(PlanningStep::Save));
  });
}

void qKerfPlanningPage::WireSegment() {
  connect(segment_, &qKerfSegmentPanel::SegmentWanted, this,
          [this] { jobs_->Segment(segment_->Preset()); });
  connect(segment_, &qKerfSegmentPanel::ToolChanged, this, &qKerfPlanningPage::ToolChanged);
  connect(segment_, &qKerfSegmentPanel::ClearSeedsWanted, this, [this] { session_->ClearSeeds(); });
  connect(segment_, &qKerfSegmentPanel::FillChanged, this,
          [this](double fill) { views_->SetFill(fill); });
  connect(segment_, &qKerfSegmentPanel::CheckWanted, this, [this] { jobs_->Check(); });
  connect(segment_, &qKerfSegmentPanel::EvolveWanted, this,
          [this] { jobs_->Evolve(segment_->ActiveLabel()); });
  connect(jobs_, &PlanningJobs::ContourMoved, views_, &PlanningViews::ShowContour);
  connect(segment_, &qKerfSegmentPanel::ImportLabelsWanted, this,
          [this](const QString& path) { jobs_->ImportLabels(path, this); });
  connect(segment_, &qKerfSegmentPanel::VisibilityChanged, this, [this](int label, bool visible) {
    session_->LabelInfos()[label - 1].visible = visible;
    session_->LabelListChanged();
    ShowModel();
  });
  connect(segment_, &qKerfSegmentPanel::ColorChanged, this, [this](int label, const QColor& c) {
    session_->LabelInfos()[label - 1].color = {std::uint8_t(c.red()), std::uint8_t(c.green()),
                                               std::uint8_t(c.blue())};
    session_->LabelListChanged();
    ShowModel();
  });
  connect(segment_, &qKerfSegmentPanel::ThresholdWanted, this, [this](int low, int high) {
    if (low > high) {
      host_->Say(qKerfHost::Problem, tr("The lower threshold lies above the upper one: exchange "
                                        "them."));
      return;
    }
    if (!session_->Ct()) return;
    const int label = segment_->ActiveLabel();
    // Inner structures are looked for in the organ, the organ everywhere.
    const int within = label == 1 ? 0 : session_->Labels().Count(1) > 0 ? 1 : 0;
    jobs_->RunTool(tr("Threshold"), "threshold",
                   [ct = *session_->Ct(), label, low, high, within](const kerf::LabelMap& labels,
                                                                    kerf::Progress& progress) {
                     return kerf::ThresholdTool(ct, labels, label, low, high, within, progress);
                   });
  });
  connect(segment_, &qKerfSegmentPanel::CleanWanted, this, [this](const QString& operation) {
    const int label = segment_->ActiveLabel();
    jobs_->RunTool(tr("Correcting"),
                   operation.endsWith("islands") ? "remove islands"
                   : operation.endsWith("holes") ? "fill holes"
                   : operation == "largest"      ? "keep largest part"
                                                 : "smooth",
                   [label, operation](const kerf::LabelMap& labels, kerf::Progress& progress) {
                     if (operation == "largest")
                       return kerf::KeepLargestTool(labels, label, progress);
                     if (operation == "islands")
                       return kerf::RemoveIslandsTool(labels, label, 1.0, progress);
                     if (operation == "holes") return kerf::FillHolesTool(labels, label, progress);
                     return kerf::SmoothTool(labels, label, 2.5, progress);
                   });
  });
  connect(segment_, &qKerfSegmentPanel::BooleanWanted, this,
          [this](int other, int operation, double reach_mm) {
            const int label = segment_->ActiveLabel();
            if (other == label) {
              host_->Say(qKerfHost::Problem,
                         tr("Choose two different labels: one in the list, one to combine with."));
              return;
            }
            jobs_->RunTool(tr("Combining labels"), "combine labels",
                           [label, other, operation, reach_mm](const kerf::LabelMap& labels,
                                                               kerf::Progress& progress) {
                             return kerf::BooleanTool(
                                 labels, label, other,
                                 static_cast<kerf::BooleanOperation>(operation), reach_mm,
                                 progress);
                           });
          });
  connect(views_, &PlanningViews::ToolPressed, this, &qKerfPlanningPage::Pressed);
  connect(views_, &PlanningViews::ToolMoved, this, &qKerfPlanningPage::Dragged);
  connect(views_, &PlanningViews::ToolReleased, this, &qKerfPlanningPage::Released);
}

void qKerfPlanningPage::WireRest() {
  connect(mesh_, &qKerfMeshPanel::MeshWanted, this, [this] { jobs_->Mesh(mesh_->Tetrahedra()); });
  connect(mesh_, &qKerfMeshPanel::QualityToggled, this, &qKerfPlanningPage::ShowModel);
  connect(plan_, &qKerfPlanPanel::MarginChanged, this, [this](double mm) {
    session_->SetMargin(mm);
    views_->ShowMargin(true);
  });
  connect(plan_, &qKerfPlanPanel::DepthChanged, this,
          [this](double mm) { session_->SetDepth(mm); });
  connect(plan_, &qKerfPlanPanel::ClearLineWanted, this, [this] { session_->ClearLine(); });
  connect(plan_, &qKerfPlanPanel::DrawingToggled, this, [this](bool on) {
    views_->Scene()->SetPicking(on);
    host_->ShowStatus(on ? tr("Click points on the organ; dragging turns it.") : QString());
  });
  connect(plan_, &qKerfPlanPanel::DirectionFromViewWanted, this,
          [this] { session_->SetDirection(views_->Scene()->ViewDirection()); });
  connect(plan_, &qKerfPlanPanel::DirectionFromSurfaceWanted, this,
          [this] { session_->FollowSurface(); });
  connect(plan_, &qKerfPlanPanel::MeasureWanted, this, [this] {
    plan_->StopDrawing();
    jobs_->Measure();
  });
  connect(plan_, &qKerfPlanPanel::ColorsToggled, this, &qKerfPlanningPage::ShowModel);
  connect(camera_, &qKerfCameraPanel::CameraWanted, this, &qKerfPlanningPage::OpenCamera);
  connect(camera_, &qKerfCameraPanel::ReadLandmarksWanted, this,
          &qKerfPlanningPage::ReadLandmarkFile);
  connect(camera_, &qKerfCameraPanel::PlacingToggled, this,
          [this](bool on) { views_->Scene()->SetPicking(on); });
  connect(camera_, &qKerfCameraPanel::RenameWanted, this,
          [this](int i, const QString& name) { session_->RenameLandmark(i, name.toStdString()); });
  connect(camera_, &qKerfCameraPanel::RemoveWanted, this,
          [this](int i) { session_->RemoveLandmark(i); });
  connect(views_->Scene(), &qKerfSceneView::Picked, this, &qKerfPlanningPage::Picked);
  connect(save_, &qKerfSavePanel::SaveWanted, this,
          [this](const QString& folder) { jobs_->Save(folder, views_->Scene()->Picture()); });
  connect(jobs_, &PlanningJobs::Saved, this, [this](const QString& folder) {
    recovery_->Forget();
    host_->SetCurrentCase(folder);
    host_->Say(qKerfHost::Info, tr("The case is saved in %1.").arg(qKerfShortPath(folder)));
  });
  connect(save_, &qKerfSavePanel::ContinueWanted, this, [this] {
    if (!host_->ShowModule("intraoperative"))
      host_->Say(qKerfHost::Warning, tr("The module for the operating room is not installed. The "
                                        "case is saved and can be taken there."));
  });
}

void qKerfPlanningPage::MakeShortcuts() {
  const auto add = [this](QWidget* where, const QString& id, const QString& text,
                          const QString& key, std::function<void()> act) {
    auto* action = new QAction(text, where);
    action->setShortcut(QKeySequence(key));
    connect(action, &QAction::triggered, this, [act = std::move(act)] { act(); });
    // Keys work where their widget is shown: a tool's on the page of its step alone.
    where->addAction(action);
    host_->AddShortcut("planning/" + id, action);
  };
  const struct {
    Tool tool;
    const char *id, *text, *key;
  } tools[] = {{Tool::Look, "look", "Tool: look", "1"},
               {Tool::Seed, "seed", "Tool: seed", "2"},
               {Tool::Paint, "paint", "Tool: paint", "3"},
               {Tool::Erase, "erase", "Tool: erase", "4"},
               {Tool::Grow, "grow", "Tool: grow", "5"}};
  for (const auto& t : tools)
    add(segment_, t.id, tr(t.text), t.key, [this, tool = t.tool] { segment_->SetTool(tool); });
  for (int step = 0; step < kerf::kPlanningSteps; ++step)
    add(this, QStringLiteral("step-%1").arg(step + 1), tr("Planning: step %1").arg(step + 1),
        QStringLiteral("Alt+%1").arg(step + 1), [this, step] { steps_->SetCurrent(step); });
  add(this, "save", tr("Planning: save the case"), "Ctrl+S", [this] {
    steps_->SetCurrent(static_cast<int>(PlanningStep::Save));
    if (save_->Folder().isEmpty())
      host_->Say(qKerfHost::Info, tr("Give the case a folder, then save."));
    else
      jobs_->Save(save_->Folder(), views_->Scene()->Picture());
  });
}

void qKerfPlanningPage::Listen(PlanningChange change) {
  switch (change) {
    case PlanningChange::Volume:
      views_->ShowVolume();
      break;
    case PlanningChange::Labels:
      // The mesh of other labels is not shown, and comes back when the edit is undone.
      if (!stroking_ && session_->Model()) ShowModel();
      views_->ShowLabels();
      break;
    case PlanningChange::LabelList:
      views_->ShowLabelList();
      break;
    case PlanningChange::Seeds:
    case PlanningChange::Landmarks:
      views_->ShowMarkers();
      break;
    case PlanningChange::Model:
    case PlanningChange::Plan:
      ShowModel();
      break;
    default:
      break;
  }
  recovery_->Touched();
  // Many changes in one turn (every dab of a stroke) are one look at the panels.
  if (refresh_waits_) return;
  refresh_waits_ = true;
  QTimer::singleShot(stroking_ ? 150 : 0, this, [this] {
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

void qKerfPlanningPage::ToolChanged() {
  const Tool tool = segment_->CurrentTool();
  const bool brush = tool == Tool::Paint || tool == Tool::Erase;
  views_->SetTool(tool != Tool::Look && session_->Ct(), brush ? segment_->Radius_mm() : 0);
}

void qKerfPlanningPage::Pressed(int slice, const kerf::Vec3& index) {
  const kerf::GridGeometry& grid = session_->Ct()->grid;
  for (int a = 0; a < 3; ++a)
    if (index[a] < -0.5 || index[a] > grid.size[a] - 0.5) return;
  const Tool tool = segment_->CurrentTool();
  const int label = segment_->ActiveLabel();
  if (tool == Tool::Seed) {
    session_->AddSeed(segment_->SeedKind().toStdString(), grid.WorldFromIndex(index));
  } else if (tool == Tool::Grow) {
    const Eigen::Vector3i seed = index.array().round().cast<int>();
    jobs_->RunTool(tr("Growing"), "grow",
                   [ct = *session_->Ct(), label, seed, tolerance = segment_->Tolerance_hu()](
                       const kerf::LabelMap& labels, kerf::Progress& progress) {
                     return kerf::GrowTool(ct, labels, label, seed, tolerance, 150, progress);
                   });
  } else if (tool == Tool::Paint || tool == Tool::Erase) {
    stroke_ = kerf::LabelEditor::Brush();
    stroke_.radius_mm = segment_->Radius_mm();
    stroke_.flat_axis = segment_->IsFlat() ? views_->Slices()[slice]->Frame().n_axis : -1;
    stroke_.paint = tool == Tool::Paint ? static_cast<std::uint8_t>(label) : 0;
    stroke_.only_over = tool == Tool::Erase ? label : -1;
    stroking_ = true;
    session_->BeginStroke();
    last_dab_ = index;
    session_->Dab(stroke_, index);
  }
}

void qKerfPlanningPage::Dragged(int, const kerf::Vec3& index) {
  if (!stroking_) return;
  // Dabs close enough that a quick stroke has no gaps.
  const kerf::Vec3 spacing = session_->Ct()->grid.spacing_mm;
  const kerf::Vec3 way = index - last_dab_;
  const double step_mm = std::max(0.5, 0.5 * stroke_.radius_mm);
  const int dabs =
      std::max(1, static_cast<int>(std::ceil(way.cwiseProduct(spacing).norm() / step_mm)));
  for (int d = 1; d <= dabs; ++d) session_->Dab(stroke_, last_dab_ + way * (double(d) / dabs));
  last_dab_ = index;
}

void qKerfPlanningPage::Released() {
  if (!stroking_) return;
  stroking_ = false;
  session_->EndStroke(stroke_.paint == 0 ? "erase" : "paint");
}

void qKerfPlanningPage::Picked(const kerf::Vec3& origin_mm, const kerf::Vec3& direction) {
  const auto& model = session_->Model();
  if (!model) return;
  const auto hit = kerf::SurfaceTree(model->organ_surface).FirstHit({origin_mm, direction});
  if (!hit) {
    host_->ShowStatus(tr("There is no organ under the pointer."));
    return;
  }
  if (plan_->IsDrawing()) session_->AddLinePoint(hit->point);
  if (camera_->IsPlacing()) session_->AddLandmark(hit->point);
}

void qKerfPlanningPage::OpenCamera(const QString& path) {
  try {
    const std::string file = path.toStdString();
    session_->SetCamera(kerf::CameraFileHasPose(file) ? kerf::ReadCameraFile(file)
                                                      : kerf::ReadCameraIntrinsics(file),
                        file);
    host_->Say(qKerfHost::Info, {});
  } catch (const std::exception& error) {
    host_->Say(qKerfHost::Problem, tr("This camera file cannot be used: %1. Choose the camera.yml "
                                      "that kerf calibrate wrote.")
                                       .arg(QString::fromStdString(error.what())));
  }
}

void qKerfPlanningPage::ReadLandmarkFile(const QString& path) {
  try {
    session_->SetLandmarks(kerf::ReadCaseLandmarks(path.toStdString()));
    host_->Say(qKerfHost::Info, {});
  } catch (const std::exception& error) {
    host_->Say(qKerfHost::Problem,
               tr("These landmarks cannot be read: %1").arg(QString::fromStdString(error.what())));
  }
}

void qKerfPlanningPage::OpenCt(const QString& path) { jobs_->Open(path, {}); }

bool qKerfPlanningPage::OpenCase(const QString& folder) {
  // The case that was just saved here is open already.
  if (QFileInfo(folder) == QFileInfo(QString::fromStdString(session_->CaseFolderPath())) &&
      !session_->IsDirty())
    return true;
  jobs_->OpenCase(folder);
  return true;
}

void qKerfPlanningPage::Recover() {
  kerf::PlanningWork work;
  try {
    work = kerf::LoadWork(recovery_->File().toStdString());
  } catch (const std::exception& error) {
    host_->Say(qKerfHost::Problem,
               tr("The work cannot be recovered: %1").arg(QString::fromStdString(error.what())));
    return;
  }
  recovery_bar_->hide();
  auto shared = std::make_shared<kerf::PlanningWork>(std::move(work));
  jobs_->Open(QString::fromStdString(shared->ct_path), QString::fromStdString(shared->series),
              [this, shared] {
                if (!shared->labels.grid.SameAs(session_->Ct()->grid)) {
                  host_->Say(qKerfHost::Problem,
                             tr("The CT was changed since: the work does not fit it."));
                  return;
                }
                session_->Restore(shared->labels, shared->rest);
                steps_->SetCurrent(static_cast<int>(PlanningStep::Segment));
                host_->Say(qKerfHost::Info, tr("The work is back. Make the mesh again (step 3)."));
              });
}

bool qKerfPlanningPage::CanClose() {
  if (!session_->IsDirty()) {
    recovery_->Forget();
    return true;
  }
  const auto answer = QMessageBox::question(
      this, tr("Unsaved work"),
      tr("The planning has changes that no case holds. Close without saving?"),
      QMessageBox::Discard | QMessageBox::Cancel, QMessageBox::Cancel);
  if (answer != QMessageBox::Discard) return false;
  recovery_->Forget();
  return true;
}

void qKerfPlanningPage::dragEnterEvent(QDragEnterEvent* event) {
  if (event->mimeData()->hasUrls()) event->acceptProposedAction();
}

void qKerfPlanningPage::dropEvent(QDropEvent* event) {
  const QList<QUrl> urls = event->mimeData()->urls();
  if (urls.isEmpty() || !urls[0].isLocalFile()) return;
  event->acceptProposedAction();
  OpenCt(urls[0].toLocalFile());
}
