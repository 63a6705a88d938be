// Nothing painted is lost: undone and done again by keys, recovered after a crash. With real
// events.
#include <QAction>
#include <QApplication>
#include <QDir>
#include <QFile>
#include <QProcess>
#include <csignal>
#include <cstdio>

#include "Adapters/Itk/VolumeFiles.h"
#include "Application/qKerfMainWindow.h"
#include "GuiDriver.h"
#include "SmallCt.h"

namespace {

constexpr char kCrash[] = "--paint-and-be-killed";

/// The other process of the recovery test: paints, waits for the autosave, and is killed.
int PaintAndBeKilled(const QString& folder, const QString& ct) {
  GuiDriver gui(folder);
  gui.Drop(ct);
  gui.Idle();
  gui.Paint();
  const double painted = gui.Volume_ml(0);
  const QString autosave = GuiDriver::Unsaved(folder).filePath("autosave.kerfwork");
  if (!QTest::qWaitFor([&] { return QFile::exists(autosave); }, 20000)) return 1;
  std::printf("%.1f\n", painted);
  std::fflush(stdout);
  std::raise(SIGKILL);
  return 0;
}

}  // namespace

class PlanningRecoveryGuiTest : public QObject {
  Q_OBJECT
 private slots:
  void initTestCase() {
    kerf::WriteVolume(ct_.toStdString(), kerf::testing::SmallCt());
    QDir().mkpath(Path("run"));
  }
  void cleanup() { gui_.reset(); }
  void PaintUndoRedoByKeys();
  void KilledAndRecovered();
  void WhatComesNextDoesNotTakeItsPlace();

 private:
  /// Another process paints and is killed. @return what it painted, ml; −1 where it was not killed
  double Killed(const QString& run);
  QString Path(const QString& name) const { return folder_.filePath(name); }
  QTemporaryDir folder_;
  const QString ct_ = Path("ct.nrrd");
  std::unique_ptr<GuiDriver> gui_;
};

void PlanningRecoveryGuiTest::PaintUndoRedoByKeys() {
  gui_ = std::make_unique<GuiDriver>(Path("run"));
  gui_->Drop(ct_);
  QVERIFY(gui_->Idle());
  gui_->Paint();
  const double first = gui_->Volume_ml(0);
  QVERIFY2(first > 0.1, qPrintable(QString::number(first)));
  gui_->Drag("sliceCoronal", 0.4, 0.4, 0.6, 0.6);
  const double second = gui_->Volume_ml(0);
  QVERIFY(second > first);
  auto* undo = gui_->Window()->findChild<QAction*>("undoAction");
  QCOMPARE(undo->text().remove('&'), QString("Undo: paint"));
  gui_->Undo();
  QTRY_COMPARE(gui_->Volume_ml(0), first);
  gui_->Undo();
  QTRY_COMPARE(gui_->Volume_ml(0), 0.0);
  QVERIFY(!undo->isEnabled());
  QTest::keyClick(gui_->Window(), Qt::Key_Z, Qt::ControlModifier | Qt::ShiftModifier);
  QTRY_COMPARE(gui_->Volume_ml(0), first);
  QTest::keyClick(gui_->Window(), Qt::Key_Z, Qt::ControlModifier | Qt::ShiftModifier);
  QTRY_COMPARE(gui_->Volume_ml(0), second);
  // The eraser takes away, a seed is a step of its own.
  QTest::keyClick(gui_->Window(), Qt::Key_4);
  gui_->Drag("sliceAxial", 0.3, 0.45, 0.65, 0.55);
  QVERIFY(gui_->Volume_ml(0) < second);
  QCOMPARE(undo->text().remove('&'), QString("Undo: erase"));
  QTest::keyClick(gui_->Window(), Qt::Key_2);
  gui_->ClickAt("sliceAxial", 0.5, 0.5);
  QCOMPARE(undo->text().remove('&'), QString("Undo: place organ seed"));
}

double PlanningRecoveryGuiTest::Killed(const QString& run) {
  QDir().mkpath(run);
  QProcess child;
  child.start(QCoreApplication::applicationFilePath(), {kCrash, run, ct_});
  if (!child.waitForFinished(60000) || child.exitStatus() != QProcess::CrashExit) return -1;
  return child.readAllStandardOutput().trimmed().toDouble();
}

void PlanningRecoveryGuiTest::KilledAndRecovered() {
  const QString run = Path("killed");
  const double painted = Killed(run);
  QVERIFY(painted > 0);
  gui_ = std::make_unique<GuiDriver>(run);
  QVERIFY(gui_->Find("recoveryBar")->isVisible());
  QVERIFY2(gui_->Text("recoveryText").contains("ct.nrrd"), qPrintable(gui_->Text("recoveryText")));
  gui_->Click("recoverButton");
  QVERIFY(gui_->Idle());
  QTRY_COMPARE(gui_->Volume_ml(0), painted);
  QVERIFY(gui_->Find("recoveryBar")->isHidden());
  gui_->Abandon();
  // Once more, and thrown away this time.
  gui_ = std::make_unique<GuiDriver>(run);
  QVERIFY(gui_->Find("recoveryBar")->isVisible());
  gui_->Click("discardButton");
  gui_->Abandon();
  gui_ = std::make_unique<GuiDriver>(run);
  QVERIFY(gui_->Find("recoveryBar")->isHidden());
}

void PlanningRecoveryGuiTest::WhatComesNextDoesNotTakeItsPlace() {
  const QString run = Path("next");
  const QDir work = GuiDriver::Unsaved(run);
  const double painted = Killed(run);
  QVERIFY(painted > 0);
  // Other work is begun before anybody looks at what was left, and saved for a crash as well.
  gui_ = std::make_unique<GuiDriver>(run);
  gui_->Drop(ct_);
  QVERIFY(gui_->Idle());
  gui_->Paint();
  gui_->Drag("sliceCoronal", 0.4, 0.4, 0.6, 0.6);
  const double next = gui_->Volume_ml(0);
  QVERIFY(next > painted);
  QTRY_VERIFY_WITH_TIMEOUT(work.exists("autosave.kerfwork"), 10000);
  gui_->Abandon();
  // Now both were left: the newer is offered first, and neither is in the other's way.
  gui_ = std::make_unique<GuiDriver>(run);
  gui_->Click("recoverButton");
  QVERIFY(gui_->Idle());
  QTRY_COMPARE(gui_->Volume_ml(0), next);
  QVERIFY(gui_->Find("recoveryBar")->isVisible());
  QCOMPARE(work.entryList({"left-*"}).size(), 2);
  // What was recovered stays in its file until the autosave holds it.
  QTRY_COMPARE_WITH_TIMEOUT(work.entryList({"left-*"}).size(), 1, 10000);
  QVERIFY(work.exists("autosave.kerfwork"));
  gui_->Abandon();
  QVERIFY(QFile::remove(work.filePath("autosave.kerfwork")));
  gui_ = std::make_unique<GuiDriver>(run);
  gui_->Click("recoverButton");
  QVERIFY(gui_->Idle());
  QTRY_COMPARE(gui_->Volume_ml(0), painted);
}

int main(int argc, char** argv) {
  if (argc == 4 && QString(argv[1]) == kCrash) {
    const auto app = MakeGuiApplication(argc, argv);
    return PaintAndBeKilled(argv[2], argv[3]);
  }
  return RunGuiTest<PlanningRecoveryGuiTest>(argc, argv);
}

#include "PlanningRecoveryGuiTest.moc"
