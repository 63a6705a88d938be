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
class PlanningMouse;
class PlanningRecovery;
class PlanningViews;
class qKerfCameraPanel;
class qKerfHost;
class qKerfImportPanel;
class qKerfMeshPanel;
class qKerfPlanPanel;
class qKerfSavePanel;
class qKerfSegmentPanel;
class qKerfSeriesTable;
class qKerfStepList;

/// The planning page: steps on the left, views on the right. Wires widgets, session and jobs.
class qKerfPlanningPage : public QWidget {
  Q_OBJECT
 public:
  explicit qKerfPlanningPage(qKerfHost* host, QWidget* parent = nullptr);
  ~qKerfPlanningPage() override;

  bool OpenCase(const QString& folder);
  bool CanLeaveCase();
  bool CanClose();
  /// As the Open buttons do; the page comes to the front.
  void OpenCt(const QString& path);
  kerf::PlanningSession& Session() { return *session_; }

 private:
  void MakeLayout();
  QWidget* MakeViewBar();
  void MakeRecoveryBar();
  void ShowLeftWork();
  void WireImport();
  void WireSegment();
  void WireRest();
  void MakeShortcuts();
  void Listen(kerf::PlanningChange change);
  void RefreshPanels();
  void ShowModel();
  void StepChosen(int step);
  void Recover();
  /// Asks where work would be lost.
  bool MayDropWork(const QString& question);

  qKerfHost* host_;
  std::unique_ptr<kerf::PlanningSession> session_;
  PlanningViews* views_;
  PlanningJobs* jobs_;
  PlanningRecovery* recovery_;
  PlanningMouse* mouse_;
  qKerfStepList* steps_;
  QStackedWidget* panels_;
  qKerfImportPanel* import_;
  qKerfSegmentPanel* segment_;
  qKerfMeshPanel* mesh_;
  qKerfPlanPanel* plan_;
  qKerfCameraPanel* camera_;
  qKerfSavePanel* save_;
  qKerfSeriesTable* series_;
  QFrame* recovery_bar_;
  QLabel* recovery_text_;
  QComboBox* window_;
  bool refresh_waits_ = false;
};
