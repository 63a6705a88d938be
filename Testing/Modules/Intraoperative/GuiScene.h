#pragma once

#include <QCheckBox>
#include <QLabel>
#include <QLineEdit>
#include <QListWidget>
#include <QPushButton>
#include <QSlider>
#include <QTableWidget>
#include <QTemporaryDir>
#include <QtTest>
#include <filesystem>

#include "Common/qKerfTheme.h"
#include "Intraoperative/qKerfIntraoperativeWidget.h"
#include "Intraoperative/qKerfVideoView.h"
#include "PlannedStudy.h"
#include "Support/MeteredApplication.h"
#include "Support/TestDisplay.h"

/// What the GUI tests share: a planned case of a study, the page in a window, and hands.
namespace kerf::testing {

struct Page {
  explicit Page(QSize size = {1500, 860}) {
    qKerfIntraoperativeWidget::Services services;
    services.say_problem = [this](const QString& text) { problems << text; };
    widget = std::make_unique<qKerfIntraoperativeWidget>(std::move(services));
    widget->resize(size);
    widget->show();
    (void)QTest::qWaitForWindowExposed(widget.get());
    QApplication::setActiveWindow(widget.get());  // no window manager does it here
  }
  template <class T>
  T* Find(const char* name) {
    T* found = widget->findChild<T*>(name);
    if (!found) qFatal("no %s", name);
    return found;
  }
  void Click(const char* name) { QTest::mouseClick(Find<QWidget>(name), Qt::LeftButton); }
  void Type(const char* name, const QString& text, bool enter = false) {
    auto* line = Find<QLineEdit>(name);
    line->setFocus();
    line->clear();
    QTest::keyClicks(line, text);
    if (enter) QTest::keyClick(line, Qt::Key_Return);
  }
  void Key(Qt::Key key) { QTest::keyClick(widget->View(), key); }
  QPoint At(const Vec2& pixel) {
    return widget->View()->ToWidget(QPointF(pixel.x(), pixel.y())).toPoint();
  }
  void Drag(const Vec2& from, const Vec2& to, Qt::MouseButton button = Qt::LeftButton) {
    auto* view = widget->View();
    QTest::mousePress(view, button, {}, At(from));
    for (int i = 1; i <= 12; ++i) {
      const Vec2 p = from + (to - from) * (i / 12.0);
      QMouseEvent move(QEvent::MouseMove, At(p), view->mapToGlobal(At(p)), Qt::NoButton, button,
                       {});
      QApplication::sendEvent(view, &move);
    }
    QTest::mouseRelease(view, button, {}, At(to));
  }
  std::shared_ptr<const IntraoperativeSnapshot> Latest() { return widget->Desk().Latest(); }
  QString ChecksText() {
    QString all;
    auto* list = Find<QListWidget>("checks");
    for (int i = 0; i < list->count(); ++i) all += list->item(i)->text() + "\n";
    return all;
  }
  QString TextOf(const char* label) { return Find<QLabel>(label)->text(); }
  /// Every picture of a file is registered, as fast as that goes.
  void UseEveryFrame() {
    CaptureOptions options;
    options.every = true;
    options.paced = false;
    widget->Desk().SetCaptureOptions(options);
  }
  /// A session over every frame of these pictures, from the given pose. @return whether it runs
  bool BeginSession(const QString& case_folder, const QString& pictures) {
    UseEveryFrame();
    widget->OpenCase(case_folder);
    widget->OpenSource(pictures);
    if (!QTest::qWaitFor([&] { return widget->Desk().Newest().has_value(); }, 20000)) return false;
    widget->StartWithGivenPose();
    return widget->CurrentStep() == qKerfIntraoperativeWidget::Run;
  }
  /// Goes through the check-in with these pictures and takes the offered session up again. @return
  /// whether it is being registered
  bool TakeUpAgain(const QString& pictures) {
    Type("source", pictures, true);
    Type("confirmed", QString::fromStdString(widget->Desk().Pseudonym()));
    auto* proceed = Find<QPushButton>("register");
    if (!QTest::qWaitFor([&] { return proceed->isEnabled(); }, 20000)) {
      qWarning("%s", qPrintable(ChecksText()));
      return false;
    }
    Click("resume");
    if (widget->CurrentStep() != qKerfIntraoperativeWidget::Exposure) return false;
    Click("accept_registration");
    return true;
  }
  /// Presses Export. @return whether all files are there and none is empty
  bool Exports() {
    Click("export");
    auto* files = Find<QListWidget>("exported");
    if (!QTest::qWaitFor([&] { return files->count() > 20; }, 60000)) return false;
    const std::filesystem::path session = widget->Desk().SessionPath();
    for (int i = 0; i < files->count(); ++i)
      if (std::filesystem::file_size(session / files->item(i)->text().toStdString()) == 0)
        return false;
    return true;
  }
  std::unique_ptr<qKerfIntraoperativeWidget> widget;
  QStringList problems;
};

/// Share of pixels that differ by more than 12 of 255.
inline double Difference(const QImage& a, const QImage& b) {
  if (a.size() != b.size()) return 1.0;
  int differ = 0;
  for (int y = 0; y < a.height(); ++y)
    for (int x = 0; x < a.width(); ++x) {
      const QRgb p = a.pixel(x, y), q = b.pixel(x, y);
      differ += std::abs(qRed(p) - qRed(q)) + std::abs(qGreen(p) - qGreen(q)) +
                    std::abs(qBlue(p) - qBlue(q)) >
                36;
    }
  return double(differ) / (a.width() * a.height());
}

inline Image FromQImage(const QImage& picture) {
  const QImage bgr = picture.convertToFormat(QImage::Format_BGR888);
  Image image;
  image.width = bgr.width();
  image.height = bgr.height();
  for (int y = 0; y < image.height; ++y)
    image.data.insert(image.data.end(), bgr.constScanLine(y),
                      bgr.constScanLine(y) + std::size_t(image.width) * 3);
  return image;
}

inline QImage ToQImage(const Image& image) {
  return QImage(image.data.data(), image.width, image.height, image.width * 3,
                QImage::Format_BGR888)
      .copy();
}

/// main() of a test of the page.
template <class Test>
int RunGuiTest(int argc, char** argv) {
  if (!DisplayForQt()) return kNoDisplay;
  MeteredApplication app(argc, argv);
  qKerfTheme::Apply(app, qgetenv("KERF_GUI_THEME") != "light");
  Test test;
  return QTest::qExec(&test, argc, argv);
}

}  // namespace kerf::testing
