#pragma once

#include <QWidget>

#include "Session/PlanningSession.h"

class QCheckBox;
class QLabel;
class QPushButton;
class QSlider;

/// Step 3: how fine, make it, what came of it.
class qKerfMeshPanel : public QWidget {
  Q_OBJECT
 public:
  explicit qKerfMeshPanel(QWidget* parent = nullptr);
  void Show(const kerf::PlanningSession& session);
  int Tetrahedra() const;
  bool QualityShown() const;

 signals:
  void MeshWanted();
  void QualityToggled();

 private:
  void ShowExpected(double organ_ml);
  QSlider* slider_;
  QLabel *expected_, *report_, *embedding_;
  QPushButton* make_;
  QCheckBox* quality_;
  double organ_ml_ = 0;
};
