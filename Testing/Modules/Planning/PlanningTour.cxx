#include <QAction>
#include <QApplication>
#include <QDir>
#include <QDoubleSpinBox>
#include <QElapsedTimer>
#include <QLineEdit>
#include <cstdio>

#include "Application/qKerfApplicationHost.h"
#include "Application/qKerfMainWindow.h"
#include "GuiDriver.h"

/// Goes through planning as a person would and takes a picture of every step.
/// PlanningTour STUDY OUTPUT WIDTH HEIGHT dark|light
int main(int argc, char** argv) {
  QTemporaryDir run;
  qputenv("HOME", run.path().toUtf8());  // pictures show ~, not this machine
  const auto app = MakeGuiApplication(argc, argv);
  if (!app) return kerf::testing::kNoDisplay;
  if (argc != 6) {
    std::fprintf(stderr, "PlanningTour STUDY OUTPUT WIDTH HEIGHT dark|light\n");
    return 2;
  }
  const QString study = argv[1], output = argv[2];
  const QSize size(atoi(argv[3]), atoi(argv[4]));
  GuiDriver gui(run.path());
  gui.Window()->resize(size);
  if (QString(argv[5]) == "light") gui.Window()->findChild<QAction*>("darkAction")->trigger();
  int number = 0;
  const auto shoot = [&](const QString& name) {
    QTest::qWait(900);  // the 3-D preview follows when the hand rests
    gui.Idle();
    QTest::qWait(1500);
    const QString file =
        QStringLiteral("%1/planning-%2-%3.png").arg(output).arg(++number).arg(name);
    gui.Window()->grab().save(file);
    std::printf("%s\n", qPrintable(file));
  };
  QElapsedTimer clock;
  const auto timed = [&](const char* what) {
    clock.start();
    gui.Idle(300000);
    std::printf("%s: %.1f s\n", what, clock.elapsed() / 1000.0);
  };
  gui.Drop(study + "/ct.nii.gz");
  timed("open");
  shoot("import");
  gui.Step(1);
  gui.Click("segmentButton");
  timed("segment");
  gui.Click("toolPaint");
  shoot("segment");
  gui.Step(2);
  gui.Click("meshButton");
  timed("mesh");
  gui.Click("qualityCheck");
  shoot("mesh");
  gui.Click("qualityCheck");
  gui.Step(3);
  gui.Click("lookFromA");
  QTest::qWait(300);
  gui.Click("drawLineButton");
  // Across the upper pole, below the tumour; clicks beside the organ are not taken.
  for (int p = 0; p < 24; ++p) gui.ClickAt("sceneCanvas", 0.28 + 0.02 * p, 0.41);
  gui.Click("drawLineButton");
  qobject_cast<QDoubleSpinBox*>(gui.Find("depthSpin"))->setValue(80);
  QTest::qWait(100);
  gui.Click("measureButton");
  timed("measure");
  shoot("plan");
  gui.Step(4);
  gui.ChooseFile("openCameraButton", study + "/camera.yml");
  gui.Click("placeLandmarksButton");
  for (const auto& [x, y] : {std::pair(0.38, 0.2), {0.42, 0.55}, {0.6, 0.5}, {0.54, 0.8}})
    gui.ClickAt("sceneCanvas", x, y);
  gui.Click("placeLandmarksButton");
  shoot("camera");
  gui.Step(5);
  QTest::keyClicks(gui.Find("caseFolderEdit"), "~/cases/kidney");
  gui.Click("saveButton");
  timed("save");
  shoot("save");
  gui.Window()->ShowPage("cases");
  shoot("cases");
  return 0;
}
