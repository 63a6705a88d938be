// The page of the operating room in the whole window, with its plugins: what page and window share.
#include <QAction>
#include <QApplication>
#include <QDir>
#include <QFile>
#include <QLabel>
#include <QLineEdit>
#include <QPushButton>

#include "Application/qKerfApplicationHost.h"
#include "Application/qKerfMainWindow.h"
#include "CaseIO/CaseFolder.h"
#include "Framework/qKerfJobRunner.h"
#include "Modules/Planning/GuiDriver.h"
#include "PlannedStudy.h"

class WholeWindowGuiTest : public QObject {
  Q_OBJECT

 private slots:
  void initTestCase() {
    gui_ = std::make_unique<GuiDriver>(folder_.path());
    QVERIFY(gui_->Window()->ShowPage("intraoperative"));
    QTest::qWait(100);
  }
  void cleanupTestCase() { gui_->Abandon(); }

  /// The window fills the screen and keeps its panels; once more, and it is as it was.
  void F11FillsTheScreenWithTheWholeWindow() {
    for (const bool maximized : {false, true}) {
      if (maximized) Window()->setWindowState(Qt::WindowMaximized);
      QTest::qWait(100);
      Press(Qt::Key_F11);
      QTRY_VERIFY(Window()->isFullScreen());
      QVERIFY(Side()->isVisible());
      QVERIFY(Ticked());
      Press(Qt::Key_F11);
      QTRY_VERIFY(!Window()->isFullScreen());
      QVERIFY(!Ticked());
      QCOMPARE(Window()->isMaximized(), maximized);
    }
    Window()->setWindowState(Qt::WindowNoState);
  }

  /// F11 fills the screen on whatever page.
  void F11WorksEverywhere() {
    for (const char* page : {"planning", "cases", "intraoperative"}) {
      QVERIFY(Window()->ShowPage(page));
      Press(Qt::Key_F11);
      QTRY_VERIFY2(Window()->isFullScreen(), page);
      Press(Qt::Key_F11);
      QTRY_VERIFY2(!Window()->isFullScreen(), page);
    }
  }

  /// F shows the picture alone, and the menu knows that the screen is filled.
  void FShowsThePictureAlone() {
    Press(Qt::Key_F);
    QTRY_VERIFY(Window()->isFullScreen());
    QVERIFY(!Side()->isVisible());
    QTRY_VERIFY(Ticked());
    Press(Qt::Key_F);
    QTRY_VERIFY(!Window()->isFullScreen());
    QVERIFY(Side()->isVisible());
    QTRY_VERIFY(!Ticked());
  }

  /// Either key undoes its own: a window that filled the screen does so after F, too.
  void TheTwoDoNotGetInEachOthersWay() {
    Press(Qt::Key_F11);
    QTRY_VERIFY(Window()->isFullScreen());
    Press(Qt::Key_F);
    QTRY_VERIFY(!Side()->isVisible());
    QVERIFY(Window()->isFullScreen());
    Press(Qt::Key_F);
    QTRY_VERIFY(Side()->isVisible());
    QVERIFY(Window()->isFullScreen());
    Press(Qt::Key_F11);
    QTRY_VERIFY(!Window()->isFullScreen());
  }

  /// What no module can open is said, and the page stays.
  void WhatCannotBeOpenedIsSaid() {
    gui_->Drop(Written("film.mp4", "no film"));
    QVERIFY2(Said("neither a case nor a CT"), qPrintable(gui_->Message()));
    QCOMPARE(Shown(), QString("intraoperative"));
    // A broken case is no CT that cannot be read.
    QDir(folder_.path()).mkdir("broken");
    Written("broken/case.json", "{");
    gui_->Drop(folder_.filePath("broken"));
    QVERIFY2(Said("This case cannot be opened"), qPrintable(gui_->Message()));
    QVERIFY(!Busy());
  }

  /// While a session runs no module takes another case, and nothing that is dropped hides it.
  void ARunningSessionKeepsItsCaseAndItsPicture() {
    const QString phantom = KERF_TEST_PHANTOM;
    const QString folder = folder_.filePath("case"), other = folder_.filePath("other");
    for (const QString& path : {folder, other})
      kerf::testing::PlanStudyCase(phantom.toStdString(), path.toStdString(), 2000);
    QVERIFY(Window()->OpenCase(folder));
    QVERIFY(gui_->Idle());
    Type("source", phantom + "/video.mp4");
    Type("confirmed",
         QString::fromStdString(kerf::CaseFolder::Open(folder.toStdString()).Manifest().pseudonym));
    QTRY_VERIFY(Find("register")->isEnabled());
    for (const char* button : {"register", "given", "accept_registration"})
      QTest::mouseClick(Find(button), Qt::LeftButton);
    QTRY_VERIFY(Find("stop")->isVisible());

    QVERIFY(!Window()->OpenCase(other));
    QVERIFY2(Said("end it before another case"), qPrintable(gui_->Message()));
    for (const QString& path : {other, phantom + "/ct.nii.gz", phantom + "/video.mp4"}) {
      Window()->Host()->Say(qKerfHost::Info, {});
      gui_->Drop(path);
      QVERIFY2(Said("A session is running"), qPrintable(path + gui_->Message()));
      // Planning has not begun to read it either.
      QVERIFY2(!Busy(), qPrintable(path));
      QCOMPARE(Shown(), QString("intraoperative"));
    }
    QCOMPARE(Window()->Host()->CurrentCase(), folder);
    QVERIFY(Find("stop")->isVisible());

    QTest::mouseClick(Find("stop"), Qt::LeftButton);
    QTRY_VERIFY_WITH_TIMEOUT(Find("export")->isVisible(), 30000);
    QVERIFY(Window()->OpenCase(other));
    QVERIFY(gui_->Idle());
    QCOMPARE(Window()->Host()->CurrentCase(), other);
  }

 private:
  bool Said(const char* words) const { return gui_->Message().contains(words); }
  bool Busy() const { return Window()->Host()->Jobs().IsBusy(); }
  QString Shown() const { return Window()->Host()->ShownModule(); }
  QString Written(const QString& name, const QByteArray& text) const {
    QFile file(folder_.filePath(name));
    if (file.open(QIODevice::WriteOnly)) file.write(text);
    return file.fileName();
  }
  QWidget* Find(const char* name) const {
    auto* found = Page()->findChild<QWidget*>(name);
    if (!found) qFatal("no widget %s", name);
    return found;
  }
  void Type(const char* name, const QString& text) const {
    auto* line = qobject_cast<QLineEdit*>(Find(name));
    line->clear();
    QTest::keyClicks(line, text);
    QTest::keyClick(line, Qt::Key_Return);
  }
  qKerfMainWindow* Window() const { return gui_->Window(); }
  QWidget* Page() const { return Window()->findChild<QWidget*>("intraoperativePage"); }
  QWidget* Side() const { return Page()->findChild<QWidget*>("step1"); }
  bool Ticked() const { return Window()->findChild<QAction*>("fullScreenAction")->isChecked(); }
  /// To whoever has the focus, as a keyboard does.
  void Press(Qt::Key key) const {
    QApplication::setActiveWindow(Window());
    QWidget* focus = QApplication::focusWidget();
    QTest::keyClick(focus ? focus : Window(), key);
    QTest::qWait(100);
  }

  QTemporaryDir folder_;
  std::unique_ptr<GuiDriver> gui_;
};

int main(int argc, char** argv) { return RunGuiTest<WholeWindowGuiTest>(argc, argv); }

#include "WholeWindowGuiTest.moc"
