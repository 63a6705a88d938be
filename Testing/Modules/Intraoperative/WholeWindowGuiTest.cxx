// The page of the operating room in the whole window, with its plugins: what page and window share.
#include <QAction>
#include <QApplication>
#include <QPushButton>

#include "Application/qKerfMainWindow.h"
#include "Modules/Planning/GuiDriver.h"

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

 private:
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
