#pragma once

#include <QWidget>

class QLabel;
class QPushButton;
class QTableWidget;
class QCheckBox;

namespace kerf {
struct IntraoperativeSnapshot;
}

/// Step 3: the cuts and what was said about them.
class qKerfRunPanel : public QWidget {
  Q_OBJECT
 public:
  explicit qKerfRunPanel(QWidget* parent = nullptr);

  void Update(const kerf::IntraoperativeSnapshot& snapshot);
  void SetDrawing(bool drawing);
  /// @param seconds that the clamp has been closed, all in all
  void SetClamp(bool closed, int seconds);
  bool HoldsCuts() const;
  void SetHoldsCuts(bool hold);
  /// The proposal or cut that the keys act on: the selected one, else the newest; −1: none.
  int CurrentCut(const kerf::IntraoperativeSnapshot& snapshot, bool proposals_only) const;

 signals:
  void HoldChanged(bool hold);
  void AcceptWanted();
  void RejectWanted();
  void UndoWanted();
  void DrawToggled(bool drawing);
  void ConfirmWanted();
  void SnapshotWanted();
  void MarkWanted();
  void ClampToggled(bool closed);
  void StopWanted();

 private:
  QPushButton *accept_, *reject_, *undo_, *draw_, *confirm_, *clamp_;
  QCheckBox* hold_;
  QTableWidget* cuts_;
  QLabel *said_, *recording_;
};
