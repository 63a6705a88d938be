// The whole of planning without a mouse, on the phantom that `kerf phantom` makes: steps and tools
// by their keys, buttons by Tab and Space, places by the crosshair.
#include <QApplication>
#include <QDoubleSpinBox>
#include <QFile>
#include <QListWidget>
#include <array>
#include <cmath>

#include "Adapters/Itk/VolumeFiles.h"
#include "Application/qKerfMainWindow.h"
#include "GuiDriver.h"
#include "Pipelines/PlanPipeline.h"

namespace {

constexpr int kDone = 1;

}  // namespace

class PlanningKeysGuiTest : public QObject {
  Q_OBJECT
 private slots:
  void init() { gui_ = std::make_unique<GuiDriver>(folder_.path()); }
  void cleanup() { gui_->Abandon(); }
  void FromThePhantomsCtToACase();
  void ThePictureIsTurnedByKeys();

 private:
  QString Path(const QString& name) const { return folder_.filePath(name); }
  void Step(int number) const {
    QTest::keyClick(gui_->Window(), Qt::Key(Qt::Key_0 + number), Qt::AltModifier);
  }
  /// Tab leads to every widget; a press on the one that has the focus.
  void Press(const QString& widget, int key, int modifiers = Qt::NoModifier) const {
    QWidget* w = gui_->Find(widget);
    QVERIFY2(w->focusPolicy() & Qt::TabFocus, qPrintable(widget));
    w->setFocus(Qt::TabFocusReason);
    QTest::keyClick(w, Qt::Key(key), Qt::KeyboardModifiers(modifiers));
  }
  /// Ways of the axial crosshair in tens of pixels, to the right and down, with Space at each end.
  void Places(const QVector<QPoint>& ways) const {
    const int by = Qt::ControlModifier | Qt::ShiftModifier;
    for (const QPoint& way : ways) {
      for (int i = 0; i < std::abs(way.x()); ++i)
        Press("sliceAxial", way.x() > 0 ? Qt::Key_Right : Qt::Key_Left, by);
      for (int i = 0; i < std::abs(way.y()); ++i)
        Press("sliceAxial", way.y() > 0 ? Qt::Key_Down : Qt::Key_Up, by);
      Press("sliceAxial", Qt::Key_Space);
    }
  }
  QTemporaryDir folder_;
  std::unique_ptr<GuiDriver> gui_;
};

void PlanningKeysGuiTest::FromThePhantomsCtToACase() {
  const QString study = KERF_TEST_PHANTOM;
  if (!QFile::exists(study + "/ct.nii.gz")) QSKIP("the phantom is made by ctest");
  gui_->ChooseFile("openFileButton", study + "/ct.nii.gz");
  QVERIFY(gui_->Idle());
  QCOMPARE(gui_->State(0), kDone);
  Step(2);
  Press("segmentButton", Qt::Key_Space);
  QVERIFY(gui_->Idle(120000));
  QCOMPARE(gui_->State(1), kDone);

  // What was found is what the phantom was made of.
  const kerf::LabelMap truth = kerf::ReadLabelMap((study + "/labels.nii.gz").toStdString());
  std::array<double, 4> ml{};
  for (const std::uint8_t v : *truth.voxels)
    if (v < ml.size()) ml[v] += truth.grid.VoxelVolume_mm3() / 1000;
  const double organ = gui_->Volume_ml(0) + gui_->Volume_ml(1) + gui_->Volume_ml(2);
  const double true_organ = ml[1] + ml[2] + ml[3];
  QVERIFY2(std::abs(organ - true_organ) < 0.03 * true_organ,
           qPrintable(QString("%1 for %2 ml").arg(organ).arg(true_organ)));
  QVERIFY2(std::abs(gui_->Volume_ml(1) - ml[2]) < 0.25 * ml[2], qPrintable(QString::number(ml[2])));

  // A dab at the crosshair, large enough for the list's 0.1 ml, taken back.
  const double before = gui_->Volume_ml(0);
  QTest::keyClick(gui_->Window(), Qt::Key_4);
  Press("radiusSlider", Qt::Key_End);
  Press("sliceAxial", Qt::Key_Space);
  QTRY_VERIFY(gui_->Volume_ml(0) < before);
  gui_->Undo();
  QTRY_VERIFY(std::abs(gui_->Volume_ml(0) + gui_->Volume_ml(1) + gui_->Volume_ml(2) - organ) <
              0.01);

  Step(3);
  Press("meshButton", Qt::Key_Space);
  QVERIFY(gui_->Idle(120000));
  QCOMPARE(gui_->State(2), kDone);

  // From the right border of the organ over its front to the left one.
  Step(4);
  QTest::keyClick(gui_->Find("drawLineButton"), Qt::Key_Space);
  Places({{-3, 0}, {1, -2}, {1, -1}, {1, 0}, {1, 0}, {1, 1}, {1, 2}});
  QTRY_VERIFY2(gui_->Text("lineText").startsWith("7 points"), qPrintable(gui_->Text("lineText")));
  QTest::keyClick(gui_->Find("drawLineButton"), Qt::Key_Space);
  qobject_cast<QDoubleSpinBox*>(gui_->Find("depthSpin"))->setValue(90);
  QTest::qWait(50);
  Press("measureButton", Qt::Key_Space);
  QVERIFY(gui_->Idle());
  const double removed = gui_->Measure("Removed"), remnant = gui_->Measure("Remnant");
  QVERIFY2(removed > 20 && std::abs(removed + remnant - organ) < 0.01 * organ,
           qPrintable(gui_->Text("measures") + gui_->Text("measureNote")));

  Step(5);
  QTest::keyClick(gui_->Find("placeLandmarksButton"), Qt::Key_Space);
  Places({{-3, -1}, {1, -2}, {1, 0}, {1, 1}});
  auto* landmarks = qobject_cast<QListWidget*>(gui_->Find("landmarkList"));
  QTRY_COMPARE(landmarks->count(), 4);
  gui_->ChooseFile("openCameraButton", study + "/camera.yml");
  QTRY_VERIFY2(gui_->Text("cameraInfo").contains("960"), qPrintable(gui_->Message()));
  // One stack for all of it: the camera file is taken back, and comes again.
  gui_->Undo();
  QTRY_VERIFY(gui_->Text("cameraInfo").contains("No camera"));
  QTest::keyClick(gui_->Window(), Qt::Key_Z, Qt::ControlModifier | Qt::ShiftModifier);
  QTRY_VERIFY(gui_->Text("cameraInfo").contains("960"));
  Step(6);
  QTest::keyClicks(gui_->Find("caseFolderEdit"), Path("case"));
  QTest::keyClick(gui_->Find("caseFolderEdit"), Qt::Key_Return);
  QVERIFY(gui_->Idle());
  QVERIFY2(gui_->State(5) == kDone, qPrintable(gui_->Message()));

  const kerf::PlannedCase read = kerf::ReadCase(Path("case").toStdString());
  QVERIFY(std::abs(read.report.quality.volume_mm3 / 1000 - true_organ) < 0.03 * true_organ);
  QCOMPARE(int(read.landmarks.size()), 4);
  QCOMPARE(int(read.structures.size()), 2);
}

void PlanningKeysGuiTest::ThePictureIsTurnedByKeys() {
  gui_->Window()->OpenCase(Path("case"));
  QVERIFY(gui_->Idle());
  QTest::qWait(300);
  const auto picture = [this] { return gui_->Find("sceneCanvas")->grab().toImage(); };
  QImage before = picture();
  for (const int key : {Qt::Key_Left, Qt::Key_Up, Qt::Key_Plus, Qt::Key_Home}) {
    Press("sceneCanvas", key);
    QTest::qWait(100);
    const QImage now = picture();
    QVERIFY2(now != before, qPrintable(QString::number(key, 16)));
    before = now;
  }
  // The letters of the library below mean nothing here: no wires, no pictures for glasses.
  for (const int key : {Qt::Key_W, Qt::Key_3, Qt::Key_P}) {
    Press("sceneCanvas", key);
    QTest::qWait(100);
    QVERIFY2(picture() == before, qPrintable(QString::number(key, 16)));
  }
}

int main(int argc, char** argv) { return RunGuiTest<PlanningKeysGuiTest>(argc, argv); }

#include "PlanningKeysGuiTest.moc"
