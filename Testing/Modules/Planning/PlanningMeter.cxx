#include <QAction>
#include <QApplication>
#include <QComboBox>
#include <QDoubleSpinBox>
#include <QSpinBox>
#include <cstdio>
#include <functional>

#include "Adapters/Itk/VolumeFiles.h"
#include "Adapters/OpenCv/CameraFile.h"
#include "Application/qKerfApplicationHost.h"
#include "Application/qKerfMainWindow.h"
#include "GuiDriver.h"
#include "SmallCt.h"
#include "Support/MeteredApplication.h"
#include "Support/TestCameras.h"

namespace {

/// Organ of 1.4 l in a CT as large as they come.
kerf::Volume LargeCt() { return kerf::testing::EllipsoidCt({512, 512, 300}, {0.8, 0.8, 1.0}, 2.6); }

}  // namespace

/// Goes through the whole of planning as a person would and prints every event that held the window
/// up, with what was being done. Not a test: docs/performance.md has its list.
/// PlanningMeter large|CT
int main(int argc, char** argv) {
  QTemporaryDir run;
  const auto app = MakeGuiApplication(argc, argv);
  if (!app) return kerf::testing::kNoDisplay;
  if (argc != 2) {
    std::fprintf(stderr, "PlanningMeter large|CT\n");
    return 2;
  }
  QString ct = argv[1];
  if (ct == "large") {
    ct = run.filePath("ct.nrrd");
    kerf::WriteVolume(ct.toStdString(), LargeCt());
  }
  const QString camera = run.filePath("camera.yml");
  kerf::WriteCameraFile(camera.toStdString(), kerf::testing::Pinhole(960, 540, 900));
  kerf::testing::MeteredApplication::Doing("the window opens");
  GuiDriver gui(run.path());
  const auto doing = [&](const char* what, const std::function<void()>& act) {
    kerf::testing::MeteredApplication::Doing(what);
    act();
    gui.Idle(600000);
    QTest::qWait(2600);  // the 3-D preview and the autosave follow when the hand rests
    gui.Idle(600000);
    std::printf("%s: %s\n", what, qPrintable(gui.Text("stepSentence").replace('\n', ' ')));
    if (!gui.Message().isEmpty()) std::printf("  %s\n", qPrintable(gui.Message()));
  };
  const auto press = [&](const char* name) { return [&gui, name] { gui.Click(name); }; };
  const auto undo = [&] { QTest::keyClick(gui.Window(), Qt::Key_Z, Qt::ControlModifier); };

  doing("the CT is opened", [&] { gui.Drop(ct); });
  doing("slices are scrolled", [&] {
    for (int i = 0; i < 20; ++i) {
      QTest::keyClick(gui.Find("sliceAxial"), Qt::Key_Up);
      QTest::qWait(5);
    }
  });
  gui.Step(1);
  // Beside the bright tube in the organ's middle.
  gui.Click("toolSeed");
  gui.ClickAt("sliceAxial", 0.55, 0.55);
  qobject_cast<QComboBox*>(gui.Find("presetChoice"))->setCurrentIndex(1);
  doing("the organ is segmented", press("segmentButton"));
  gui.Click("toolErase");
  const auto stroke = [&](double y) { gui.Drag("sliceAxial", 0.45, y, 0.55, y); };
  doing("a stroke is erased", [&] { stroke(0.42); });
  doing("erasing goes on while the preview is made", [&] {
    stroke(0.46);
    QTest::qWait(350);
    stroke(0.5);
  });
  doing("erasing is undone", undo);
  qobject_cast<QSpinBox*>(gui.Find("thresholdLow"))->setValue(100);
  doing("an organ is made by threshold", press("thresholdButton"));
  doing("the threshold is undone", undo);
  doing("islands are removed", press("clean-islands"));
  doing("the organ is smoothed", press("clean-smooth"));
  doing("the contour snaps to edges", press("evolveButton"));
  doing("labels are combined", press("booleanButton"));
  doing("combining is undone", undo);
  doing("labels are checked", press("checkButton"));
  gui.Step(2);
  doing("the mesh is made", press("meshButton"));
  doing("quality is shown", press("qualityCheck"));
  doing("quality is hidden", press("qualityCheck"));
  doing("the plan is shown", [&] { gui.Step(3); });
  gui.Click("lookFromA");
  gui.Click("drawLineButton");
  doing("the line is drawn", [&] {
    for (int p = 0; p < 24; ++p) gui.ClickAt("sceneCanvas", 0.28 + 0.02 * p, 0.41);
  });
  gui.Click("drawLineButton");
  doing("the resection is measured", press("measureButton"));
  doing("the margin is changed",
        [&] { qobject_cast<QDoubleSpinBox*>(gui.Find("marginSpin"))->setValue(8); });
  gui.Step(4);
  doing("the camera is opened", [&] { gui.ChooseFile("openCameraButton", camera); });
  gui.Click("placeLandmarksButton");
  doing("landmarks are placed", [&] {
    for (const auto& [x, y] : {std::pair(0.4, 0.4), {0.6, 0.4}, {0.4, 0.6}, {0.6, 0.6}})
      gui.ClickAt("sceneCanvas", x, y);
  });
  gui.Step(5);
  QTest::keyClicks(gui.Find("caseFolderEdit"), run.filePath("case"));
  doing("the case is saved", press("saveButton"));
  doing("the cases are shown", [&] { gui.Window()->ShowPage("cases"); });
  doing("the theme is changed",
        [&] { gui.Window()->findChild<QAction*>("darkAction")->trigger(); });
  kerf::testing::MeteredApplication::Doing("a new window opens");
  gui.Abandon();
  GuiDriver second(run.path());
  kerf::testing::MeteredApplication::Doing("the case is opened again");
  second.Window()->OpenCase(run.filePath("case"));
  second.Idle(600000);
  QTest::qWait(2600);
  return 0;
}
