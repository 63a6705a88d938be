// What panels and keys ask for, and which job or change of the session answers it.
#include <QAction>
#include <functional>

#include "Common/qKerfPaths.h"
#include "Framework/qKerfHost.h"
#include "Planning/qKerfCameraPanel.h"
#include "Planning/qKerfImportPanel.h"
#include "Planning/qKerfMeshPanel.h"
#include "Planning/qKerfPlanPanel.h"
#include "Planning/qKerfSavePanel.h"
#include "Planning/qKerfSegmentPanel.h"
#include "Planning/qKerfSeriesTable.h"
#include "Planning/qKerfStepList.h"
#include "PlanningJobs.h"
#include "PlanningRecovery.h"
#include "PlanningViews.h"
#include "Views/qKerfSceneView.h"
#include "qKerfPlanningPage.h"

using kerf::PlanningStep;
using Tool = qKerfSegmentPanel::Tool;

namespace {

/// DICOM texts are Latin-1 where they are no valid UTF-8.
QString Words(const std::string& text) {
  const QString words = QString::fromStdString(text);
  return words.contains(QChar::ReplacementCharacter)
             ? QString::fromLatin1(text.data(), static_cast<int>(text.size()))
             : words;
}

}  // namespace

void qKerfPlanningPage::WireImport() {
  connect(import_, &qKerfImportPanel::OpenWanted, this,
          [this](const QString& path, const QString& series) { jobs_->Open(path, series); });
  connect(jobs_, &PlanningJobs::SeriesFound, this, [this](const QString& folder) {
    QVector<qKerfSeriesTable::Series> rows;
    for (const kerf::SeriesInfo& s : jobs_->Series())
      rows.push_back({QString::fromStdString(s.uid), Words(s.description), Words(s.modality),
                      Words(s.patient), Words(s.laterality), Words(s.phase),
                      QString("%1 × %2 × %3")
                          .arg(s.spacing_mm[0], 0, 'g', 3)
                          .arg(s.spacing_mm[1], 0, 'g', 3)
                          .arg(s.spacing_mm[2], 0, 'g', 3),
                      s.slices});
    series_->SetSeries(folder, rows);
    import_->SetChoosing(!rows.isEmpty());
    if (!rows.isEmpty()) steps_->SetCurrent(0);
  });
  connect(series_, &qKerfSeriesTable::Chosen, this,
          [this](const QString& folder, const QString& uid) { jobs_->Open(folder, uid); });
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
                   operation == "islands"        ? "remove islands"
                   : operation.endsWith("holes") ? "fill holes"
                   : operation == "smooth"       ? "smooth"
                                                 : "keep largest part",
                   [label, operation](const kerf::LabelMap& labels, kerf::Progress& progress) {
                     // A repair is one of the whole organ, whichever label is selected.
                     if (operation == "repair-islands")
                       return kerf::KeepLargestTool(labels, 0, progress);
                     if (operation == "repair-holes")
                       return kerf::FillHolesTool(labels, 1, progress);
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
    host_->ShowStatus(on ? tr("Click points on the organ. A drag turns it, or moves the point on "
                              "which it begins.")
                         : QString());
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
  connect(camera_, &qKerfCameraPanel::CameraWanted, jobs_, &PlanningJobs::OpenCamera);
  connect(camera_, &qKerfCameraPanel::ReadLandmarksWanted, jobs_, &PlanningJobs::ReadLandmarks);
  connect(camera_, &qKerfCameraPanel::PlacingToggled, this,
          [this](bool on) { views_->Scene()->SetPicking(on); });
  connect(camera_, &qKerfCameraPanel::RenameWanted, this,
          [this](int i, const QString& name) { session_->RenameLandmark(i, name.toStdString()); });
  connect(camera_, &qKerfCameraPanel::RemoveWanted, this,
          [this](int i) { session_->RemoveLandmark(i); });
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
