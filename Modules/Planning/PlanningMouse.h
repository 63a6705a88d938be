#pragma once

#include <QObject>
#include <memory>

#include "Geometry/SurfaceTree.h"
#include "Session/PlanningSession.h"

class PlanningJobs;
class PlanningViews;
class qKerfCameraPanel;
class qKerfHost;
class qKerfPlanPanel;
class qKerfSegmentPanel;

/// What the mouse, or Space at the crosshair, does in the views: the chosen tool in a slice, places
/// on the organ in 3-D.
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
  void SpotChosen(const kerf::Vec3& position_mm);
  /// A place on the organ, for the line or as a landmark, whichever is being made.
  void Take(const kerf::Vec3& on_organ_mm);
  /// A point of the line is under the pointer: it is moved.
  void Grabbed(const QPointF& at, bool* taken);
  void Moved(const kerf::Vec3& origin_mm, const kerf::Vec3& direction, bool over);
  /// Of the organ's surface; null without a model.
  const kerf::SurfaceTree* Tree();

  On on_;
  kerf::LabelEditor::Brush stroke_;
  kerf::Vec3 last_dab_ = kerf::Vec3::Zero();
  bool stroking_ = false;
  std::shared_ptr<const kerf::PlanningModel> tree_of_;
  std::unique_ptr<kerf::SurfaceTree> tree_;
  int grabbed_ = -1;  ///< point of the line
  bool moved_ = false;
};
