#pragma once

#include <QWidget>

#include "Session/PlanningSession.h"

class QCheckBox;
class QComboBox;
class QDoubleSpinBox;
class QLabel;
class QPushButton;
class QSlider;

/// Step 4: margin, resection line, measures.
class qKerfPlanPanel : public QWidget {
  Q_OBJECT
 public:
  explicit qKerfPlanPanel(QWidget* parent = nullptr);
  void Show(const kerf::PlanningSession& session);
  bool IsDrawing() const;
  void StopDrawing();
  bool SheetColored() const;
  bool OrganColored() const;

 signals:
  void MarginChanged(double mm);
  void DrawingToggled(bool drawing);
  void ClearLineWanted();
  void DepthChanged(double mm);
  void DirectionFromViewWanted();
  void DirectionFromSurfaceWanted();
  void MeasureWanted();
  void ColorsToggled();

 private:
  QDoubleSpinBox *margin_, *depth_;
  QPushButton *draw_, *clear_, *measure_, *from_view_, *from_surface_;
  QCheckBox *sheet_color_, *organ_color_;
  QLabel *line_, *measures_, *note_;
};
