// What each step answers to bad input: a sentence that says what to do. With real events.
#include <QAction>
#include <QApplication>
#include <QDir>
#include <QDoubleSpinBox>
#include <QFile>
#include <QLineEdit>
#include <QListWidget>
#include <QMessageBox>
#include <QPushButton>
#include <QSlider>
#include <QSpinBox>
#include <QStatusBar>
#include <QTableWidget>
#include <QTimer>
#include <filesystem>

#include "Adapters/Itk/VolumeFiles.h"
#include "Adapters/OpenCv/CameraFile.h"
#include "Application/qKerfApplicationHost.h"
#include "Application/qKerfMainWindow.h"
#include "GuiDriver.h"
#include "Logic/Itk/DicomFiles.h"
#include "SmallCt.h"
#include "Support/TestCameras.h"

namespace {

constexpr int kToDo = 0, kDone = 1, kProblem = 2;

}  // namespace

class PlanningBadInputGuiTest : public QObject {
  Q_OBJECT
 private slots:
  void initTestCase();
  void init();
  void cleanup() { gui_->Abandon(); }
  void BadInputsAreSentences();
  void EachStepAnswersBadInput();
  void MeshAndPlanAnswerBadInput();
  void WarningsOfTheImportAreRead();
  void WorkIsNotReplacedWithoutAQuestion();
  void TheWholeWindowTakesADrop();

 private:
  QString Path(const QString& name) const { return folder_.filePath(name); }
  /// Answers the question that `act` brings. @return what it asked; empty where none came
  QString Asked(const std::function<void()>& act, QMessageBox::StandardButton answer);
  QTemporaryDir folder_;
  std::unique_ptr<GuiDriver> gui_;
  const QString ct_ = Path("ct.nrrd"), camera_ = Path("camera.yml");
};

void PlanningBadInputGuiTest::initTestCase() {
  kerf::WriteVolume(ct_.toStdString(), kerf::testing::SmallCt());
  kerf::WriteCameraFile(camera_.toStdString(), kerf::testing::Pinhole(960, 540, 900));
}

void PlanningBadInputGuiTest::init() {
  QDir(Path("run")).removeRecursively();
  QDir().mkpath(Path("run"));
  gui_ = std::make_unique<GuiDriver>(Path("run"));
}

QString PlanningBadInputGuiTest::Asked(const std::function<void()>& act,
                                       QMessageBox::StandardButton answer) {
  QString text;
  QTimer look;
  connect(&look, &QTimer::timeout, this, [&] {
    auto* box = qobject_cast<QMessageBox*>(QApplication::activeModalWidget());
    if (!box) return;
    look.stop();
    text = box->text();
    box->button(answer)->click();
  });
  look.start(20);
  act();
  gui_->Idle();
  QApplication::setActiveWindow(gui_->Window());  // where no window manager does
  return text;
}

void PlanningBadInputGuiTest::BadInputsAreSentences() {
  QFile text(Path("letter.nii"));
  QVERIFY(text.open(QIODevice::WriteOnly));
  text.write("Dear colleague");
  text.close();
  gui_->Drop(Path("letter.nii"));
  QVERIFY(gui_->Idle());
  QVERIFY2(gui_->Message().contains("letter.nii"), qPrintable(gui_->Message()));
  QCOMPARE(gui_->State(0), kToDo);
  gui_->Drop(Path("missing.nrrd"));
  QVERIFY(gui_->Idle());
  QVERIFY2(gui_->Message().contains("missing.nrrd"), qPrintable(gui_->Message()));
  // A camera file that is none: the CT stays, the sentence says what to choose.
  gui_->Drop(ct_);
  QVERIFY(gui_->Idle());
  QCOMPARE(gui_->State(0), kDone);
  gui_->Step(4);
  gui_->ChooseFile("openCameraButton", Path("letter.nii"));
  QVERIFY(gui_->Idle());
  QVERIFY2(gui_->Message().contains("camera.yml"), qPrintable(gui_->Message()));
  gui_->Step(1);
  gui_->ChooseFile("importLabelsButton", Path("letter.nii"));
  QVERIFY(gui_->Idle());
  QVERIFY2(gui_->Message().contains("letter.nii"), qPrintable(gui_->Message()));
  // Seeds nowhere and nothing to find: a kidney in nothing but fat.
  kerf::Volume fat = kerf::testing::SmallCt();
  auto voxels = std::make_shared<std::vector<std::int16_t>>(*fat.voxels);
  for (std::int16_t& v : *voxels) v = std::min<std::int16_t>(v, -80);
  fat.voxels = voxels;
  kerf::WriteVolume(Path("fat.nrrd").toStdString(), fat);
  gui_->Drop(Path("fat.nrrd"));
  QVERIFY(gui_->Idle());
  gui_->Click("segmentButton");
  QVERIFY(gui_->Idle());
  QVERIFY(!gui_->Message().isEmpty());
  QCOMPARE(gui_->Volume_ml(0), 0.0);
}

void PlanningBadInputGuiTest::EachStepAnswersBadInput() {
  // What went wrong, then what to do; one line, without addresses and calls of libraries.
  const auto answers = [this](const QString& what_was_wrong, const QString& what_to_do) {
    QVERIFY(gui_->Idle());
    const QString said = gui_->Message();
    QVERIFY2(said.contains(what_was_wrong) && said.contains(what_to_do), qPrintable(said));
    QVERIFY2(!said.contains('\n') && !said.contains("0x"), qPrintable(said));
  };
  const auto write = [this](const QString& name, const QByteArray& text) {
    QFile file(Path(name));
    file.open(QIODevice::WriteOnly);
    file.write(text);
    return Path(name);
  };
  const auto status = [this] { return gui_->Window()->statusBar()->currentMessage(); };

  // 1 Import
  QDir().mkpath(Path("empty"));
  gui_->Drop(Path("empty"));
  answers("the folder is empty", "Open a CT as");
  gui_->Drop(write("letter.txt", "Dear colleague"));
  answers("unknown image format", "Open a CT as");
  QFile whole(ct_);
  QVERIFY(whole.open(QIODevice::ReadOnly));
  gui_->Drop(write("cut-off.nrrd", whole.read(2000)));
  answers("expected", "export it again");
  for (const char* name : {"meshButton", "measureButton", "placeLandmarksButton", "saveButton"})
    QVERIFY2(!gui_->Find(name)->isEnabled(), name);
  gui_->Drop(ct_);
  QVERIFY(gui_->Idle());
  QVERIFY2(gui_->Message().isEmpty(), qPrintable(gui_->Message()));

  // 2 Segment
  gui_->Step(1);
  gui_->Click("toolSeed");
  gui_->ClickAt("sliceAxial", 0.5, 0.01);
  QVERIFY2(status().contains("no CT under the pointer"), qPrintable(status()));
  gui_->ClickAt("sliceAxial", 0.5, 0.5);
  gui_->Click("segmentButton");
  answers("Seeds need to know the organ", "choose the preset");
  gui_->Click("clearSeedsButton");
  gui_->Click("evolveButton");
  answers("label is empty", "paint or grow a start");
  qobject_cast<QSpinBox*>(gui_->Find("thresholdLow"))->setValue(500);
  gui_->Click("thresholdButton");
  answers("lies above", "exchange them");
  gui_->ChooseFile("importLabelsButton", ct_);
  answers("labels are integers", "Choose a label map");
  // What was wrong does not stand over what goes well.
  qobject_cast<QSpinBox*>(gui_->Find("thresholdLow"))->setValue(100);
  gui_->Click("thresholdButton");
  QVERIFY(gui_->Idle());
  QVERIFY2(gui_->Message().isEmpty(), qPrintable(gui_->Message()));

  // 3 Mesh, 4 Plan: a line of one point cannot be measured, a click beside the organ says so
  gui_->Step(2);
  qobject_cast<QSlider*>(gui_->Find("tetrahedraSlider"))->setValue(10);
  gui_->Click("meshButton");
  QVERIFY(gui_->Idle());
  gui_->Step(3);
  gui_->Click("drawLineButton");
  gui_->ClickAt("sceneCanvas", 0.03, 0.03);
  QVERIFY2(status().contains("no organ under the pointer"), qPrintable(status()));
  gui_->ClickAt("sceneCanvas", 0.5, 0.5);
  QTRY_VERIFY(gui_->Text("lineText").contains("1 point"));
  QVERIFY(!gui_->Find("measureButton")->isEnabled());

  // 5 Camera and landmarks
  gui_->Step(4);
  gui_->ChooseFile("openCameraButton", ct_);
  answers("cannot be used", "Choose the camera.yml");
  gui_->ChooseFile("openCameraButton", write("half.yml", "%YAML:1.0\n---\nimage_width: 960\n"));
  answers("is missing", "Choose the camera.yml");
  gui_->ChooseFile("readLandmarksButton", camera_);
  answers("is no JSON", ".mrk.json");

  // 6 Save
  gui_->Step(5);
  auto* folder = qobject_cast<QLineEdit*>(gui_->Find("caseFolderEdit"));
  for (const auto& [path, wrong] : {std::pair(Path("letter.txt"), "is a file"),
                                    {folder_.path(), "holds other files"},
                                    {QString("/proc/nowhere/case"), "cannot be written"}}) {
    folder->clear();
    QTest::keyClicks(folder, path);
    gui_->Click("saveButton");
    answers(wrong, "Choose another folder");
  }
  folder->clear();
  QVERIFY(!gui_->Find("saveButton")->isEnabled());
}

void PlanningBadInputGuiTest::MeshAndPlanAnswerBadInput() {
  gui_->Drop(ct_);
  QVERIFY(gui_->Idle());
  const auto paint = [this](int label, int radius_mm) {
    gui_->Step(1);
    qobject_cast<QTableWidget*>(gui_->Find("labelList"))->setCurrentCell(label, 1);
    qobject_cast<QSlider*>(gui_->Find("radiusSlider"))->setValue(radius_mm);
    gui_->Click("toolPaint");
  };
  const auto mesh = [this] {
    gui_->Step(2);
    gui_->Click("meshButton");
    QVERIFY(gui_->Idle());
  };
  // A tumour and no organ around it.
  paint(1, 5);
  gui_->Drag("sliceAxial", 0.45, 0.5, 0.55, 0.5);
  mesh();
  QVERIFY2(gui_->Message().contains("no organ yet"), qPrintable(gui_->Message()));
  QVERIFY(gui_->Text("checklist").contains("Segment the organ (step 2)"));
  QVERIFY(!gui_->Find("saveButton")->isEnabled());
  gui_->Undo();
  // Two pieces: said, with what to do, and repaired by one press.
  paint(0, 8);
  gui_->Click("sphereCheck");
  gui_->ClickAt("sliceAxial", 0.3, 0.5);
  gui_->ClickAt("sliceAxial", 0.7, 0.5);
  mesh();
  const QString said = gui_->Message();
  QVERIFY2(said.contains("1 part(s) apart from the organ are left out"), qPrintable(said));
  QVERIFY2(said.contains("check the labels (step 2)"), qPrintable(said));
  gui_->Step(1);
  gui_->Click("checkButton");
  QVERIFY(gui_->Idle());
  QVERIFY2(gui_->Text("findings").contains("Keep the largest"), qPrintable(gui_->Text("findings")));
  const auto undo_text = [this] {
    return gui_->Window()->findChild<QAction*>("undoAction")->text().remove('&');
  };
  const double both = gui_->Volume_ml(0);
  gui_->Click("repairIslands");
  QVERIFY(gui_->Idle());
  QTRY_VERIFY(gui_->Volume_ml(0) < 0.7 * both);
  QCOMPARE(undo_text(), QString("Undo: keep largest part"));
  QTRY_VERIFY(gui_->Find("repairIslands")->isHidden());

  // A hole, whichever of the two was kept; the selected label does not matter.
  const double whole = gui_->Volume_ml(0);
  paint(0, 3);
  gui_->Click("toolErase");
  gui_->ClickAt("sliceAxial", 0.3, 0.5);
  gui_->ClickAt("sliceAxial", 0.7, 0.5);
  QTRY_VERIFY(gui_->Volume_ml(0) < whole);
  gui_->Click("checkButton");
  QVERIFY(gui_->Idle());
  QVERIFY2(gui_->Text("findings").contains("Fill them"), qPrintable(gui_->Text("findings")));
  qobject_cast<QTableWidget*>(gui_->Find("labelList"))->setCurrentCell(2, 1);
  gui_->Click("repairHoles");
  QVERIFY(gui_->Idle());
  QTRY_COMPARE(gui_->Volume_ml(0), whole);
  QCOMPARE(undo_text(), QString("Undo: fill holes"));
  mesh();
  QCOMPARE(gui_->State(2), kDone);
  QVERIFY2(gui_->Message().isEmpty(), qPrintable(gui_->Message()));

  // A line that does not go across the organ.
  gui_->Step(3);
  gui_->Click("lookFromA");
  QTest::qWait(200);
  gui_->Click("drawLineButton");
  gui_->ClickAt("sceneCanvas", 0.48, 0.5);
  gui_->ClickAt("sceneCanvas", 0.52, 0.5);
  QTRY_COMPARE(gui_->Text("lineText"), QString("2 points on the organ"));
  gui_->Click("drawLineButton");
  qobject_cast<QDoubleSpinBox*>(gui_->Find("depthSpin"))->setValue(1);
  QTest::qWait(50);
  gui_->Click("measureButton");
  QVERIFY(gui_->Idle());
  QCOMPARE(gui_->State(3), kProblem);
  QVERIFY2(gui_->Text("measureNote").contains("draw the line across its whole width"),
           qPrintable(gui_->Text("measureNote")));
}

void PlanningBadInputGuiTest::WarningsOfTheImportAreRead() {
  const QString dicom = Path("dicom");
  QDir().mkpath(dicom);
  for (int slice = 0; slice < 5; ++slice) {
    kerf::testing::DicomFile file(20, 16, 3.0 * slice, slice);  // 2 mm thick
    file.Write(dicom.toStdString() + "/" + std::to_string(slice) + ".dcm");
  }
  gui_->Drop(dicom);
  QVERIFY(gui_->Idle());
  QCOMPARE(gui_->State(0), kProblem);
  QVERIFY2(gui_->Message().contains("slice thickness 2.00 mm"), qPrintable(gui_->Message()));
  QVERIFY2(gui_->Message().contains("gaps between them"), qPrintable(gui_->Message()));
  QVERIFY2(!gui_->Message().contains(folder_.path()), "the path was just chosen");
  QCOMPARE(gui_->Text("stepSentence"), QString("Read the warnings; then go on."));
  QVERIFY(gui_->Text("importWarnings").contains("the distance of the positions was taken"));
  QVERIFY(gui_->Find("importWarnings")->isVisible());
  QVERIFY(gui_->Text("checklist").contains("1 warning(s) about the CT"));
  // The next CT has none.
  gui_->Drop(ct_);
  QVERIFY(gui_->Idle());
  QCOMPARE(gui_->State(0), kDone);
  QVERIFY(gui_->Text("importWarnings").isEmpty() && gui_->Message().isEmpty());
}

void PlanningBadInputGuiTest::WorkIsNotReplacedWithoutAQuestion() {
  gui_->Drop(ct_);
  QVERIFY(gui_->Idle());
  gui_->Paint();
  const double painted = gui_->Volume_ml(0);
  QVERIFY(painted > 0);
  const QString autosave = GuiDriver::Unsaved(Path("run")).filePath("autosave.kerfwork");
  QTRY_VERIFY_WITH_TIMEOUT(QFile::exists(autosave), 10000);
  const auto open = [this] { gui_->Drop(ct_); };
  const QString question = Asked(open, QMessageBox::Cancel);
  QVERIFY2(question.contains("no case holds"), qPrintable(question));
  QCOMPARE(gui_->Volume_ml(0), painted);
  QVERIFY(!Asked(open, QMessageBox::Discard).isEmpty());
  QTRY_COMPARE(gui_->Volume_ml(0), 0.0);
  QVERIFY2(!QFile::exists(autosave), "what was given up is not offered after a crash");
  // Nothing to lose, nothing asked.
  QVERIFY(Asked(open, QMessageBox::Cancel).isEmpty());
}

void PlanningBadInputGuiTest::TheWholeWindowTakesADrop() {
  gui_->Window()->ShowPage("cases");
  gui_->Drop(ct_);
  QVERIFY(gui_->Idle());
  QCOMPARE(gui_->Window()->Host()->ShownModule(), QString("planning"));
  QCOMPARE(gui_->State(0), kDone);
  // A case folder is opened as one, and not while there is work that it would replace.
  gui_->Click("segmentButton");
  QVERIFY(gui_->Idle());
  gui_->Step(2);
  gui_->Click("meshButton");
  QVERIFY(gui_->Idle());
  gui_->Step(5);
  QTest::keyClicks(gui_->Find("caseFolderEdit"), Path("case"));
  gui_->Click("saveButton");
  QVERIFY(gui_->Idle());
  QCOMPARE(gui_->State(5), kDone);
  gui_->Paint();
  const double painted = gui_->Volume_ml(0);
  const auto open = [this] { gui_->Drop(Path("case")); };
  QVERIFY(Asked(open, QMessageBox::Cancel).contains("no case holds"));
  QCOMPARE(gui_->Volume_ml(0), painted);
  QVERIFY(!Asked(open, QMessageBox::Discard).isEmpty());
  QTRY_VERIFY(gui_->Volume_ml(0) != painted);
  QCOMPARE(gui_->State(2), kDone);
  // Work that is done while a case is being read is asked about when the case is there.
  const QString again = Path("again");
  std::filesystem::copy(Path("case").toStdString(), again.toStdString(),
                        std::filesystem::copy_options::recursive);
  gui_->Step(1);
  gui_->Click("toolPaint");
  const auto open_and_paint = [&] {
    gui_->Drop(again);
    gui_->Drag("sliceAxial", 0.35, 0.45, 0.6, 0.55);
  };
  const QString late = Asked(open_and_paint, QMessageBox::Cancel);
  QVERIFY2(late.contains("while the case was read"), qPrintable(late));
  QTRY_COMPARE(gui_->Volume_ml(0), painted);
  QVERIFY2(gui_->Message().contains("keeps its work"), qPrintable(gui_->Message()));
}

int main(int argc, char** argv) { return RunGuiTest<PlanningBadInputGuiTest>(argc, argv); }

#include "PlanningBadInputGuiTest.moc"
