#include "GuiDriver.h"

#include <QVTKOpenGLNativeWidget.h>

#include <QAbstractButton>
#include <QApplication>
#include <QDropEvent>
#include <QFileDialog>
#include <QLabel>
#include <QLineEdit>
#include <QMimeData>
#include <QRegularExpression>
#include <QSurfaceFormat>
#include <QTableWidget>
#include <QTimer>
#include <QToolButton>

#include "Application/qKerfApplicationHost.h"
#include "Application/qKerfMainWindow.h"
#include "Support/MeteredApplication.h"

GuiDriver::GuiDriver(const QString& folder)
    : window_(new qKerfMainWindow(folder + "/kerf.ini", {KERF_TEST_PLUGINS})) {
  window_->resize(1280, 800);
  window_->show();
  if (!QTest::qWaitForWindowExposed(window_.get())) qFatal("the window does not show");
  // There may be no window manager that would: keys go to the active window.
  QApplication::setActiveWindow(window_.get());
  window_->ShowPage("planning");
  QTest::qWait(50);
}

GuiDriver::~GuiDriver() = default;

QWidget* GuiDriver::Find(const QString& name) const {
  // Other modules may use the same names.
  auto* page = window_->findChild<QWidget*>("planningPage");
  auto* found = page ? page->findChild<QWidget*>(name) : nullptr;
  if (!found) found = window_->findChild<QWidget*>(name);
  if (!found) qFatal("no widget %s", qPrintable(name));
  return found;
}

void GuiDriver::Click(const QString& button) const {
  QTest::mouseClick(Find(button), Qt::LeftButton);
}

void GuiDriver::Undo() const {
  window_->activateWindow();
  if (!QTest::qWaitForWindowActive(window_.get())) qFatal("the window does not get the keyboard");
  QTest::keyClick(window_.get(), Qt::Key_Z, Qt::ControlModifier);
}

QString GuiDriver::Text(const QString& label) const {
  return qobject_cast<QLabel*>(Find(label))->text();
}

QString GuiDriver::Message() const {
  return Find("messageBar")->isHidden() ? QString() : Text("messageText");
}

double GuiDriver::Volume_ml(int row) const {
  return qobject_cast<QTableWidget*>(Find("labelList"))
      ->item(row, 2)
      ->text()
      .section(' ', 0, 0)
      .toDouble();
}

double GuiDriver::Measure(const QString& name) const {
  const auto found = QRegularExpression(QRegularExpression::escape(name) + "&nbsp;.*?<b>([-0-9.]+)")
                         .match(Text("measures"));
  return found.hasMatch() ? found.captured(1).toDouble() : -1.0;
}

int GuiDriver::State(int step) const {
  return Find(QStringLiteral("step%1").arg(step))->property("state").toInt();
}

void GuiDriver::Step(int step) const { Click(QStringLiteral("step%1").arg(step)); }

void GuiDriver::Drop(const QString& path) const {
  QMimeData mime;
  mime.setUrls({QUrl::fromLocalFile(path)});
  QDragEnterEvent enter(QPoint(50, 50), Qt::CopyAction, &mime, Qt::LeftButton, Qt::NoModifier);
  QApplication::sendEvent(window_.get(), &enter);
  QDropEvent drop(QPointF(50, 50), Qt::CopyAction, &mime, Qt::LeftButton, Qt::NoModifier);
  QApplication::sendEvent(window_.get(), &drop);
}

bool GuiDriver::Idle(int timeout_ms) const {
  const bool idle =
      QTest::qWaitFor([this] { return !window_->Host()->Jobs().IsBusy(); }, timeout_ms);
  QTest::qWait(30);
  return idle;
}

void GuiDriver::Drag(const QString& view, double x0, double y0, double x1, double y1) const {
  QWidget* w = Find(view);
  const auto at = [w](double x, double y) {
    return QPoint(int(x * w->width()), int(y * w->height()));
  };
  QTest::mousePress(w, Qt::LeftButton, Qt::NoModifier, at(x0, y0));
  for (int step = 1; step <= 8; ++step) {
    const QPoint p = at(x0 + (x1 - x0) * step / 8, y0 + (y1 - y0) * step / 8);
    // QTest::mouseMove does not carry the pressed button.
    QMouseEvent move(QEvent::MouseMove, p, w->mapToGlobal(p), Qt::NoButton, Qt::LeftButton,
                     Qt::NoModifier);
    QApplication::sendEvent(w, &move);
  }
  QTest::mouseRelease(w, Qt::LeftButton, Qt::NoModifier, at(x1, y1));
  QTest::qWait(250);  // panels follow a stroke when it rests
}

void GuiDriver::ClickAt(const QString& view, double x, double y) const {
  QWidget* w = Find(view);
  QTest::mouseClick(w, Qt::LeftButton, Qt::NoModifier,
                    QPoint(int(x * w->width()), int(y * w->height())));
}

void GuiDriver::Paint() const {
  Step(1);
  Click("toolPaint");
  Drag("sliceAxial", 0.35, 0.45, 0.6, 0.55);
}

void GuiDriver::ChooseFile(const QString& button, const QString& path) const {
  QTimer::singleShot(200, window_.get(), [path] {
    auto* dialog = qobject_cast<QFileDialog*>(QApplication::activeModalWidget());
    if (!dialog) qFatal("no file dialog");
    auto* name = dialog->findChild<QLineEdit*>("fileNameEdit");
    name->setText(path);
    QTest::keyClick(name, Qt::Key_Return);
  });
  Click(button);
  QApplication::setActiveWindow(window_.get());  // where no window manager does
}

void GuiDriver::Abandon() {
  Idle();
  window_.reset();
}

std::unique_ptr<QApplication> MakeGuiApplication(int& argc, char** argv) {
  if (!kerf::testing::DisplayForQt()) return nullptr;
  QSurfaceFormat format = QVTKOpenGLNativeWidget::defaultFormat();
  format.setSamples(0);
  QSurfaceFormat::setDefaultFormat(format);
  QApplication::setAttribute(Qt::AA_DontUseNativeDialogs);
  auto app = std::make_unique<kerf::testing::MeteredApplication>(argc, argv);
  setlocale(LC_NUMERIC, "C");  // Qt has set the machine's
  return app;
}
