#pragma once

#include <QObject>
#include <array>

#include "Session/PlanningSession.h"

class QGridLayout;
class QWidget;
class qKerfJobRunner;
class qKerfSceneView;
class qKerfSliceView;

/// The four linked views and what of the session they show.
class PlanningViews : public QObject {
  Q_OBJECT
 public:
  PlanningViews(kerf::PlanningSession& session, QObject* parent);

  QWidget* Widget() const { return widget_; }
  qKerfSceneView* Scene() const { return scene_; }
  const std::array<qKerfSliceView*, 3>& Slices() const { return slices_; }

  /// The session's volume is another one.
  void ShowVolume();
  void ShowLabels();     ///< voxels changed
  void ShowLabelList();  ///< colours, visibility
  void ShowMarkers();    ///< seeds, landmarks, line
  void ShowModel(bool quality, bool sheet_colored, bool organ_colored);
  void SetWindowLevel(double window_hu, double level_hu);
  void SetFill(double fill);
  void SetTool(bool active, double radius_mm);
  void ShowMargin(bool shown);
  /// A point of the line while it is dragged; none ends it.
  void ShowMoved(const std::optional<kerf::Vec3>& point_mm);
  /// A contour that evolves; an empty map ends it.
  void ShowContour(const kerf::LabelMap& contour);
  void SetCrosshair(const kerf::Vec3& position_mm);
  /// Shows one view on the whole page, or all four again.
  void Toggle(QWidget* view);

 signals:
  void WindowLevelChanged(double window_hu, double level_hu);
  /// @param slice index of the view (axial, coronal, sagittal)
  void ToolPressed(int slice, const kerf::Vec3& index);
  void ToolMoved(int slice, const kerf::Vec3& index);
  void ToolReleased();
  void SpotChosen(const kerf::Vec3& position_mm);

 private:
  void StartPreview();
  QColor ColorOf(int label) const;

  kerf::PlanningSession& session_;
  QWidget* widget_;
  std::array<qKerfSliceView*, 3> slices_;
  qKerfSceneView* scene_;
  QGridLayout* grid_;
  QWidget* whole_ = nullptr;
  qKerfJobRunner* previews_;
  std::uint64_t preview_state_ = 0;
  bool margin_shown_ = false, preview_waits_ = false;
  kerf::LabelMap margin_;
};
