#pragma once

#include <QWidget>

class QLabel;
class QPushButton;
class QTableWidget;

namespace kerf {
class ExposureRegistration;
}

/// Step 2: the initial registration, in whatever way, and its acceptance.
class qKerfExposurePanel : public QWidget {
  Q_OBJECT
 public:
  explicit qKerfExposurePanel(QWidget* parent = nullptr);

  /// Shows landmarks with their residuals, what comes next, and the agreement of the outlines.
  void Update(const kerf::ExposureRegistration& exposure, double contour_fit);
  /// Clicks place landmarks; otherwise dragging moves the organ.
  bool PlacingLandmarks() const;
  /// Dragging traces the organ's outline.
  bool Tracing() const;
  /// Landmark that the next click places, −1: none.
  int Selected() const;
  void Select(int landmark);

 signals:
  void GivenWanted();
  void ContourWanted();
  void UndoWanted();
  void NewPictureWanted();
  void ExcludeWanted(int landmark, bool excluded);
  void RemoveWanted(int landmark);
  void Accepted();
  void ModeChanged();

 private:
  QLabel *guide_, *advice_, *fit_;
  QPushButton *given_, *landmarks_mode_, *hand_mode_, *trace_mode_, *undo_, *accept_;
  QTableWidget* table_;
  bool filling_ = false;
};
