#include <QAction>
#include <QApplication>
#include <QCheckBox>
#include <QComboBox>
#include <QDir>
#include <QDoubleSpinBox>
#include <QElapsedTimer>
#include <QFile>
#include <QLineEdit>
#include <QListWidget>
#include <QScrollArea>
#include <QScrollBar>
#include <QSlider>

#include "Adapters/Itk/VolumeFiles.h"
#include "Adapters/OpenCv/CameraFile.h"
#include "Application/qKerfApplicationHost.h"
#include "Application/qKerfMainWindow.h"
#include "CaseIO/CaseFolder.h"
#include "CaseIO/Markups.h"
#include "GuiDriver.h"
#include "Pipelines/PlanPipeline.h"
#include "SmallCt.h"
#include "Support/TestCameras.h"

namespace {

constexpr int kToDo = 0, kDone = 1, kProblem = 2;

}  // namespace

/// The whole way from a CT to a case, with real events: on a small CT of known geometry
/// and on a whole abdomen.
class PlanningGuiTest : public QObject {
  Q_OBJECT
 private slots:
  void initTestCase();
  void init();
  void cleanup();
  void StartsEmptyAndSaysWhatToDo();
  void CancelLeavesTheLabelsAlone();
  void FromCtToCase();
  void LiverOfAWholeAbdomen();
  void BothThemesAndSizes();

 private:
  QString Path(const QString& name) const { return folder_->filePath(name); }
  /// Steps 5 and 6. @param places in fractions of the 3-D view, all on the organ
  void PlaceCameraAndLandmarks(const QVector<QPointF>& places);
  void Save();
  /// The panel that holds this widget is seen whole.
  void AllIsSeen(const QString& widget) const;
  std::unique_ptr<QTemporaryDir> folder_;
  std::unique_ptr<GuiDriver> gui_;
  QString ct_, camera_;
};

void PlanningGuiTest::initTestCase() {
  folder_ = std::make_unique<QTemporaryDir>();
  ct_ = Path("ct.nrrd");
  kerf::WriteVolume(ct_.toStdString(), kerf::testing::SmallCt());
  camera_ = Path("camera.yml");
  kerf::WriteCameraFile(camera_.toStdString(), kerf::testing::Pinhole(960, 540, 900));
}

void PlanningGuiTest::init() {
  QDir(Path("run")).removeRecursively();
  QDir(Path("case")).removeRecursively();
  QDir().mkpath(Path("run"));
  gui_ = std::make_unique<GuiDriver>(Path("run"));
}

void PlanningGuiTest::cleanup() { gui_.reset(); }

void PlanningGuiTest::StartsEmptyAndSaysWhatToDo() {
  QCOMPARE(gui_->Window()->Plugins().isEmpty(), false);
  bool planning = false;
  for (const qKerfPlugin& p : gui_->Window()->Plugins()) planning |= p.name == "planning";
  QVERIFY(planning);
  for (int step = 0; step < 6; ++step) QCOMPARE(gui_->State(step), kToDo);
  QVERIFY(gui_->Text("stepSentence").contains("Open a CT"));
  QVERIFY(!gui_->Find("segmentButton")->isEnabled());
  QVERIFY(!gui_->Find("saveButton")->isEnabled());
  QVERIFY(gui_->Find("recoveryBar")->isHidden());
  // A key of the window that a module has, too, would do neither.
  for (const auto& own : gui_->Window()->Host()->Shortcuts())
    for (const auto& other : gui_->Window()->Host()->Shortcuts())
      if (own.id.startsWith("application/") && !other.id.startsWith("application/"))
        QVERIFY2(own.action->shortcut() != other.action->shortcut(), qPrintable(other.id));
}

void PlanningGuiTest::CancelLeavesTheLabelsAlone() {
  gui_->Drop(ct_);
  QVERIFY(gui_->Idle());
  gui_->Paint();
  const double painted = gui_->Volume_ml(0);
  const auto steps = gui_->Window()->Host()->Undo().Count();
  gui_->Click("segmentButton");
  QVERIFY(gui_->Window()->Host()->Jobs().IsBusy());
  QTRY_VERIFY(gui_->Find("jobCancel")->isVisible());
  QElapsedTimer clock;
  clock.start();
  gui_->Click("jobCancel");
  QVERIFY(gui_->Idle(15000));
  QCOMPARE(gui_->Volume_ml(0), painted);
  QCOMPARE(gui_->Window()->Host()->Undo().Count(), steps);
  QVERIFY(!gui_->Find("jobCancel")->isVisible());
  QVERIFY(gui_->Message().isEmpty());
}

void PlanningGuiTest::PlaceCameraAndLandmarks(const QVector<QPointF>& places) {
  gui_->Step(4);
  gui_->ChooseFile("openCameraButton", camera_);
  QTRY_VERIFY2(gui_->Text("cameraInfo").contains("960"), qPrintable(gui_->Message()));
  gui_->Click("placeLandmarksButton");
  for (const QPointF& at : places) gui_->ClickAt("sceneCanvas", at.x(), at.y());
  QTRY_COMPARE(qobject_cast<QListWidget*>(gui_->Find("landmarkList"))->count(), places.size());
}

void PlanningGuiTest::Save() {
  gui_->Step(5);
  QTest::keyClicks(gui_->Find("caseFolderEdit"), Path("case"));
  QVERIFY(gui_->Find("saveButton")->isEnabled());
  gui_->Click("saveButton");
  QVERIFY(gui_->Idle());
  QVERIFY2(gui_->State(5) == kDone, qPrintable(gui_->Message()));
  QCOMPARE(gui_->Window()->Host()->CurrentCase(), Path("case"));
  QTRY_VERIFY(!GuiDriver::Unsaved(Path("run")).exists("autosave.kerfwork"));
}

void PlanningGuiTest::AllIsSeen(const QString& widget) const {
  QWidget* at = gui_->Find(widget);
  while (at && !qobject_cast<QScrollArea*>(at)) at = at->parentWidget();
  QVERIFY2(at, "no scroll area");
  QTRY_VERIFY2(qobject_cast<QScrollArea*>(at)->verticalScrollBar()->maximum() == 0,
               qPrintable(widget));
}

void PlanningGuiTest::FromCtToCase() {
  gui_->Drop(ct_);
  QVERIFY(gui_->Idle());
  QCOMPARE(gui_->State(0), kDone);
  gui_->Step(1);
  gui_->Click("segmentButton");
  QVERIFY(gui_->Idle());
  const double organ = gui_->Volume_ml(0) + gui_->Volume_ml(1) + gui_->Volume_ml(2);
  QVERIFY2(std::abs(organ - 79.6) < 6, qPrintable(QString::number(organ)));
  QVERIFY2(gui_->Volume_ml(1) > 0.7, "tumour");
  QVERIFY2(gui_->Volume_ml(2) > 0.5, "inner structure");
  QVERIFY(!gui_->Text("segmentationWarnings").isEmpty());
  AllIsSeen("segmentButton");

  gui_->Step(2);
  qobject_cast<QSlider*>(gui_->Find("tetrahedraSlider"))->setValue(20);
  gui_->Click("meshButton");
  QVERIFY(gui_->Idle());
  QCOMPARE(gui_->State(2), kDone);
  QVERIFY(gui_->Text("meshReport").contains("Tetrahedra"));

  // A line across the organ, seen from the front, left of its middle.
  gui_->Step(3);
  gui_->Click("lookFromA");
  QTest::qWait(100);
  gui_->Click("drawLineButton");
  for (const double y : {0.295, 0.33, 0.4, 0.5, 0.6, 0.67, 0.705})
    gui_->ClickAt("sceneCanvas", 0.5, y);
  gui_->Click("drawLineButton");
  QTest::qWait(50);
  qobject_cast<QDoubleSpinBox*>(gui_->Find("depthSpin"))->setValue(60);
  gui_->Click("directionViewButton");
  QTest::qWait(50);
  gui_->Click("measureButton");
  QVERIFY(gui_->Idle());
  AllIsSeen("measureButton");
  const QString measures = gui_->Text("measures");
  QVERIFY2(measures.contains("Remnant"), qPrintable(measures + gui_->Text("measureNote")));
  QVERIFY2(measures.contains("Sheet to tumour"), qPrintable(measures));
  // The organ is an ellipsoid about the line's plane, the tumour's rim lies 9 mm beside it, the
  // vessel crosses it.
  QVERIFY2(std::abs(gui_->Measure("Remnant") - 0.5 * organ) < 0.03 * organ, qPrintable(measures));
  QVERIFY2(std::abs(gui_->Measure("Sheet to tumour") - 9.0) < 2.0, qPrintable(measures));
  QCOMPARE(gui_->Measure("Sheet to vessels, calyces"), 0.0);
  QCOMPARE(gui_->Measure("Tumour left behind"), 0.0);

  PlaceCameraAndLandmarks({{0.4, 0.4}, {0.6, 0.4}, {0.4, 0.6}, {0.6, 0.6}});
  AllIsSeen("openCameraButton");
  Save();
  AllIsSeen("saveButton");

  // The files, checked against their hashes, as replay opens them.
  const kerf::CaseFolder opened = kerf::CaseFolder::Open(Path("case").toStdString());
  for (const char* role : {"ct", "segmentation", "organ_mesh", "organ_surface", "tumour",
                           "internal", "camera", "landmarks", "plan", "preview"})
    QVERIFY2(opened.Has(role), role);
  const kerf::PlannedCase read = kerf::ReadCase(Path("case").toStdString());
  QCOMPARE(int(read.landmarks.size()), 4);
  QCOMPARE(read.camera->width, 960);
  QVERIFY(read.report.quality.manifold_boundary);
  const auto line = kerf::ReadMarkups(opened.Path("plan"));
  QCOMPARE(line[0].type, std::string("Curve"));
  QVERIFY(line[0].points.size() >= 5);

  // `kerf plan` makes the same mesh of the same CT, bit for bit.
  kerf::PlanRequest request;
  request.input = ct_.toStdString();
  request.meshing.tetrahedra = std::stoi(opened.Manifest().provenance.at("tetrahedra_wanted"));
  kerf::Progress silent;
  const kerf::PlannedCase planned = kerf::Plan(request, silent);
  QCOMPARE(read.mesh.TetCount(), planned.mesh.TetCount());
  QVERIFY(read.mesh.rest == planned.mesh.rest);
  QVERIFY(read.mesh.tets == planned.mesh.tets);
  QCOMPARE(opened.Manifest().provenance.at("input_sha256"), planned.provenance.at("input_sha256"));

  // A change afterwards makes the mesh stale and says so; undo brings it back.
  gui_->Step(1);
  gui_->Click("toolErase");
  gui_->Drag("sliceAxial", 0.3, 0.5, 0.7, 0.5);
  QTRY_COMPARE(gui_->State(2), kProblem);
  gui_->Undo();
  QTRY_COMPARE(gui_->State(2), kDone);

  // The case is in the browser and opens again.
  gui_->Abandon();
  gui_ = std::make_unique<GuiDriver>(Path("run"));
  gui_->Window()->ShowPage("cases");
  auto* cases = qobject_cast<QListWidget*>(gui_->Find("caseList"));
  QCOMPARE(cases->count(), 1);
  QVERIFY2(cases->item(0)->text().contains("ready for the operating room"),
           qPrintable(cases->item(0)->text()));
  gui_->Click("openCaseButton");
  QVERIFY(gui_->Idle());
  QTRY_COMPARE(gui_->State(2), kDone);
  QVERIFY(std::abs(gui_->Volume_ml(0) + gui_->Volume_ml(1) + gui_->Volume_ml(2) - organ) < 0.2);
}

void PlanningGuiTest::LiverOfAWholeAbdomen() {
  const QString data = qEnvironmentVariable("KERF_DATA", KERF_DATA_DEFAULT);
  const QString ct = data + "/ct-abdomen/ct.nii.gz";
  if (!QFile::exists(ct)) QSKIP("there is no ct-abdomen below KERF_DATA");
  gui_->Drop(ct);
  QVERIFY(gui_->Idle());
  gui_->Step(1);
  // A kidney needs a seed: there are two. The sentence says so.
  auto* preset = qobject_cast<QComboBox*>(gui_->Find("presetChoice"));
  preset->setCurrentIndex(2);
  gui_->Click("segmentButton");
  QVERIFY(gui_->Idle());
  QVERIFY2(gui_->Message().contains("seed"), qPrintable(gui_->Message()));
  preset->setCurrentIndex(1);
  gui_->Click("segmentButton");
  QVERIFY(gui_->Idle(120000));
  QVERIFY2(gui_->Message().isEmpty(), "the sentence of before has gone");
  const double ml = gui_->Volume_ml(0) + gui_->Volume_ml(1) + gui_->Volume_ml(2);
  QVERIFY2(ml > 900 && ml < 2500, qPrintable(QString::number(ml)));
  gui_->Step(2);
  gui_->Click("meshButton");
  QVERIFY(gui_->Idle(120000));
  QCOMPARE(gui_->State(2), kDone);

  // From the front: a line from above the liver to below it; clicks beside it are not taken.
  gui_->Step(3);
  gui_->Click("lookFromA");
  QTest::qWait(200);
  gui_->Click("drawLineButton");
  for (int p = 2; p < 49; ++p) gui_->ClickAt("sceneCanvas", 0.6, 0.02 * p);
  gui_->Click("drawLineButton");
  qobject_cast<QDoubleSpinBox*>(gui_->Find("depthSpin"))->setValue(200);
  gui_->Click("directionViewButton");
  QTest::qWait(50);
  gui_->Click("measureButton");
  QVERIFY(gui_->Idle(120000));
  const double removed = gui_->Measure("Removed"), remnant = gui_->Measure("Remnant");
  QVERIFY2(removed > 50 && removed < remnant, qPrintable(gui_->Text("measureNote")));
  QVERIFY2(std::abs(removed + remnant - ml) < 0.02 * ml, qPrintable(gui_->Text("measures")));
  PlaceCameraAndLandmarks({{0.35, 0.35}, {0.4, 0.45}, {0.5, 0.35}, {0.6, 0.35}});
  Save();

  const kerf::CaseFolder opened = kerf::CaseFolder::Open(Path("case").toStdString());
  for (const char* role : {"ct", "segmentation", "organ_mesh", "camera", "landmarks", "plan"})
    QVERIFY2(opened.Has(role), role);
  const kerf::PlannedCase read = kerf::ReadCase(Path("case").toStdString());
  QVERIFY(read.report.quality.manifold_boundary);
  QCOMPARE(read.report.quality.components, 1);
  QVERIFY2(read.mesh.TetCount() > 5000, qPrintable(QString::number(read.mesh.TetCount())));
  QVERIFY(std::abs(read.report.quality.volume_mm3 / 1000 - ml) < 0.02 * ml);
  QCOMPARE(int(read.landmarks.size()), 4);
}

void PlanningGuiTest::BothThemesAndSizes() {
  gui_->Drop(ct_);
  QVERIFY(gui_->Idle());
  auto* dark = gui_->Window()->findChild<QAction*>("darkAction");
  QVERIFY(dark->isChecked());
  const QColor before = gui_->Window()->palette().color(QPalette::Window);
  dark->trigger();
  QTest::qWait(50);
  QVERIFY(gui_->Window()->palette().color(QPalette::Window).lightness() > before.lightness() + 100);
  // The module follows, not the frame alone: dark text on light.
  QTRY_VERIFY2(gui_->Text("checklist").contains("#16191d"), qPrintable(gui_->Text("checklist")));
  for (const QSize& size : {QSize(1280, 800), QSize(1920, 1080)}) {
    gui_->Window()->resize(size);
    QTest::qWait(100);
    QCOMPARE(gui_->Window()->size(), size);
    for (int step = 0; step < 6; ++step) {
      gui_->Step(step);
      QTest::qWait(20);
      // Nothing of a panel is cut off at its right edge.
      for (const char* name : {"openFolderButton", "segmentButton", "meshButton", "drawLineButton",
                               "openCameraButton", "saveButton"}) {
        QWidget* w = gui_->Find(name);
        if (!w->isVisible()) continue;
        const int right = w->mapTo(gui_->Window(), QPoint(w->width(), 0)).x();
        QVERIFY2(right <= gui_->Find("sliceAxial")->mapTo(gui_->Window(), QPoint()).x(), name);
      }
    }
  }
}

int main(int argc, char** argv) { return RunGuiTest<PlanningGuiTest>(argc, argv); }

#include "PlanningGuiTest.moc"
