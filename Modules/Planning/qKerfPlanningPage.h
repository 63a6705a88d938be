#pragma once

#include <QColor>
#include <QWidget>
#include <memory>

#include "Session/PlanningSession.h"

class QComboBox;
class QFrame;
class QLabel;
class QStackedWidget;
class PlanningJobs;
class PlanningRecovery;
class PlanningViews;
class qKerfCameraPanel;
class qKerfHost;
class qKerfImportPanel;
class qKerfMeshPanel;
class qKerfPlanPanel;
class qKerfSavePanel;
class qKerfSegmentPanel;
class qKerfStepList;

/// The planning page: steps on the left, views on the right. Wires widgets, session and jobs.
class qKerfPlanningPage : public QWidget {
  Q_OBJECT
 public:
  explicit qKerfPlanningPage(qKerfHost* host, QWidget* parent = nullptr);
  ~qKerfPlanningPage() override;

  bool OpenCase(const QString& folder);
  bool CanClose();
  /// As the Open buttons and a drop do.
  Q_INVOKABLE void OpenCt(const QString& path);
  kerf::PlanningSession& Session() { return *session_; }

 protected:
  void dragEnterEvent(QDragEnterEvent* event) override;
  void dropEvent(QDropEvent* event) override;

 private:
  void MakeLayout();
  QWidget* MakeViewBar();
  void MakeRecoveryBar();
  void WireImport();
  void WireSegment();
  void WireRest();
  void MakeShortcuts();
  void Listen(kerf::PlanningChange change);
  void RefreshPanels();
  void ShowModel();
  void ToolChanged();
  void Pressed(int slice, const kerf::Vec3& index);
  void Dragged(int slice, const kerf::Vec3& index);
  void Released();
  void Picked(const kerf::Vec3& origin_mm, const kerf::Vec3& direction);
  void StepChosen(int step);
  void Recover();
  void OpenCamera(const QString& path);
  void ReadLandmarkFile(const QString& path);

  qKerfHost* host_;
  std::unique_ptr<kerf::PlanningSession> session_;
  PlanningViews* views_;
  PlanningJobs* jobs_;
  PlanningRecovery* recovery_;
  qKerfStepList* steps_;
  QStackedWidget* panels_;
  qKerfImportPanel* import_;
  qKerfSegmentPanel* segment_;
  qKerfMeshPanel* mesh_;
  qKerfPlanPanel* plan_;
  qKerfCameraPanel* camera_;
  qKerfSavePanel* save_;
  QFrame* recovery_bar_;
  QLabel* recovery_text_;
  QComboBox* window_;
  kerf::LabelEditor::Brush stroke_;
  kerf::Vec3 last_dab_;
  bool stroking_ = false, refresh_waits_ = false;
};
