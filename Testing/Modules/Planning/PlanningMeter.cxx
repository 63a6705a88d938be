#include <QAction>
#include <QApplication>
#include <QComboBox>
#include <QDoubleSpinBox>
#include <QElapsedTimer>
#include <QMouseEvent>
#include <QSet>
#include <QSlider>
#include <QSpinBox>
#include <algorithm>
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

/// How quickly the real window shows what is asked for.
class Pace : public QObject {
 public:
  explicit Pace(const GuiDriver& gui) {
    for (const char* view : {"sliceAxial", "sliceCoronal", "sliceSagittal"})
      gui.Find(view)->installEventFilter(this);
  }
  /// `act`, then events until this many views have been painted and the window is on the screen.
  void Measure(const char* what, int views, int times, const std::function<void(int)>& act) {
    kerf::testing::MeteredApplication::Doing(what);
    double sum_ms = 0, worst_ms = 0;
    for (int i = 0; i < times; ++i) {
      QApplication::processEvents();
      painted_.clear();
      QElapsedTimer clock;
      clock.start();
      act(i);
      while (painted_.size() < views && clock.elapsed() < 5000) QApplication::processEvents();
      const double ms = 1e-6 * static_cast<double>(clock.nsecsElapsed());
      sum_ms += ms;
      worst_ms = std::max(worst_ms, ms);
    }
    std::printf("%s: %.0f times a second, %.0f ms at worst\n", what, 1000 * times / sum_ms,
                worst_ms);
  }

 protected:
  bool eventFilter(QObject* watched, QEvent* event) override {
    if (event->type() == QEvent::Paint) painted_.insert(watched);
    return false;
  }

 private:
  QSet<QObject*> painted_;
};

/// The pace of the views on the CT that is open; the brush paints for as long as it takes.
void MeasurePace(const GuiDriver& gui) {
  Pace pace(gui);
  QWidget* axial = gui.Find("sliceAxial");
  gui.Click("toolLook");
  pace.Measure("slices are scrolled", 1, 200,
               [&](int i) { QTest::keyClick(axial, i / 100 % 2 ? Qt::Key_Down : Qt::Key_Up); });
  pace.Measure("the crosshair moves, two views follow", 3, 200, [&](int i) {
    const Qt::Key key = i / 50 % 2 ? Qt::Key_Left : Qt::Key_Right;
    QTest::keyClick(axial, key, Qt::ControlModifier);
    QTest::keyClick(axial, i / 50 % 2 ? Qt::Key_Up : Qt::Key_Down, Qt::ControlModifier);
  });
  const auto at = [&](double x) {
    return QPoint(static_cast<int>(x * axial->width()), axial->height() / 2);
  };
  gui.Click("toolPaint");
  for (const char* what : {"a disc of 15 mm paints", "a ball of 15 mm paints"}) {
    QTest::mousePress(axial, Qt::LeftButton, Qt::NoModifier, at(0.3));
    pace.Measure(what, 1, 100, [&](int i) {
      const QPoint p = at(0.3 + 0.004 * i);
      QMouseEvent move(QEvent::MouseMove, p, axial->mapToGlobal(p), Qt::NoButton, Qt::LeftButton,
                       Qt::NoModifier);
      QApplication::sendEvent(axial, &move);
    });
    QTest::mouseRelease(axial, Qt::LeftButton, Qt::NoModifier, at(0.7));
    gui.Undo();
    gui.Click("sphereCheck");
  }
}

}  // namespace

/// Goes through the whole of planning as a person would and prints every event that held the window
/// up, with what was being done; then how long work took and how quickly views follow. Not a test:
/// docs/performance.md has its list. PlanningMeter large|CT
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
    QElapsedTimer clock;
    clock.start();
    act();
    gui.Idle(600000);
    const double work_s = 1e-3 * static_cast<double>(clock.elapsed());
    QTest::qWait(2600);  // the 3-D preview and the autosave follow when the hand rests
    gui.Idle(600000);
    std::printf("%s: %.1f s. %s\n", what, work_s,
                qPrintable(gui.Text("stepSentence").replace('\n', ' ')));
    if (!gui.Message().isEmpty()) std::printf("  %s\n", qPrintable(gui.Message()));
  };
  const auto press = [&](const char* name) { return [&gui, name] { gui.Click(name); }; };
  const auto undo = [&] { gui.Undo(); };

  doing("the CT is opened", [&] { gui.Drop(ct); });
  gui.Step(1);
  // Beside the bright tube in the organ's middle.
  gui.Click("toolSeed");
  gui.ClickAt("sliceAxial", 0.55, 0.55);
  qobject_cast<QComboBox*>(gui.Find("presetChoice"))->setCurrentIndex(1);
  doing("segmenting is cancelled after 2 s", [&] {
    gui.Click("segmentButton");
    QTest::qWait(2000);
    gui.Click("jobCancel");
  });
  doing("the organ is segmented", press("segmentButton"));
  qobject_cast<QSlider*>(gui.Find("radiusSlider"))->setValue(15);
  MeasurePace(gui);
  qobject_cast<QSlider*>(gui.Find("radiusSlider"))->setValue(5);
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
