#pragma once

#include <QObject>

#include "Session/PlanningSession.h"

class PlanningJobs;
class PlanningViews;
class qKerfCameraPanel;
class qKerfHost;
class qKerfPlanPanel;
class qKerfSegmentPanel;

/// What the mouse does in the views: the chosen tool in a slice, places on the organ in 3-D.
class PlanningMouse : public QObject {
  Q_OBJECT
 public:
  struct On {
    qKerfHost* host;
    kerf::PlanningSession* session;
    PlanningViews* views;
    PlanningJobs* jobs;
    qKerfSegmentPanel* segment;
    qKerfPlanPanel* plan;
    qKerfCameraPanel* camera;
  };
  PlanningMouse(const On& on, QObject* parent);
  /// A brush is down.
  bool Stroking() const { return stroking_; }

 private:
  void ToolChanged();
  void Pressed(int slice, const kerf::Vec3& index);
  void Dragged(int slice, const kerf::Vec3& index);
  void Released();
  void Picked(const kerf::Vec3& origin_mm, const kerf::Vec3& direction);

  On on_;
  kerf::LabelEditor::Brush stroke_;
  kerf::Vec3 last_dab_ = kerf::Vec3::Zero();
  bool stroking_ = false;
};
