#pragma once

#include <QWidget>
#include <array>

#include "Session/PlanningSession.h"

class QButtonGroup;
class QCheckBox;
class QComboBox;
class QDoubleSpinBox;
class QLabel;
class QPushButton;
class QSlider;
class QSpinBox;
class QStackedWidget;
class QTableWidget;
class QVBoxLayout;

/// Step 2: preset and seeds, tools, label list, checks.
class qKerfSegmentPanel : public QWidget {
  Q_OBJECT
 public:
  enum class Tool { Look, Seed, Paint, Erase, Grow };
  explicit qKerfSegmentPanel(QWidget* parent = nullptr);
  void Show(const kerf::PlanningSession& session);

  Tool CurrentTool() const;
  void SetTool(Tool tool);
  int ActiveLabel() const;
  QString SeedKind() const;
  double Radius_mm() const;
  bool IsFlat() const;
  double Tolerance_hu() const;
  QString Preset() const;  ///< liver, kidney, or empty = the one organ of the CT

 signals:
  void SegmentWanted();
  void ToolChanged();
  void ThresholdWanted(int low_hu, int high_hu);
  /// @param operation largest, islands, holes, smooth (of the selected label); repair-holes,
  /// repair-islands (of all labels together)
  void CleanWanted(const QString& operation);
  void BooleanWanted(int other, int operation, double reach_mm);
  void CheckWanted();
  void ImportLabelsWanted(const QString& path);
  void ClearSeedsWanted();
  void FillChanged(double fill);
  void VisibilityChanged(int label, bool visible);
  void ColorChanged(int label, const QColor& color);
  void EvolveWanted();

 private:
  void MakeLabelList(QVBoxLayout* column);
  void MakePreset(QVBoxLayout* column);
  void MakeTools(QVBoxLayout* column);
  void MakeToolOptions(QVBoxLayout* column);
  void MakeRange(QVBoxLayout* column);
  void MakeCleaning(QVBoxLayout* column);
  void ShowTool();

  QTableWidget* labels_;
  QComboBox *preset_, *seed_kind_, *other_, *operation_;
  QLabel *seeds_, *findings_, *warnings_;
  QButtonGroup* tools_;
  QStackedWidget* options_;
  std::array<int, 5> option_page_{};  ///< of each tool
  QSlider *radius_, *fill_;
  QLabel* radius_text_;
  QCheckBox* sphere_;
  QSpinBox *tolerance_, *low_, *high_;
  QDoubleSpinBox* reach_;
  QPushButton *segment_, *clear_seeds_, *repair_holes_, *repair_islands_;
  bool filling_ = false;
};
