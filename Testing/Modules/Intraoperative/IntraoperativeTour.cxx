#include <QAction>
#include <QApplication>
#include <QCheckBox>
#include <QDir>
#include <QLabel>
#include <QLineEdit>
#include <QListWidget>
#include <QMouseEvent>
#include <QTableWidget>
#include <QTemporaryDir>
#include <cstdio>

#include "Adapters/Ffmpeg/VideoWriter.h"
#include "Adapters/OpenCv/VideoSource.h"
#include "Application/qKerfApplicationHost.h"
#include "Application/qKerfMainWindow.h"
#include "CaseIO/CaseFolder.h"
#include "Modules/Planning/GuiDriver.h"
#include "PlannedStudy.h"

namespace {

/// The same pictures at a rate that a busy machine keeps up with: the page drops what it cannot.
void Slowed(const QString& video, const QString& slow) {
  const auto source = kerf::OpenVideo(video.toStdString());
  kerf::VideoWriter writer(slow.toStdString(), source->Width(), source->Height(), 5.0);
  while (const auto frame = source->Next()) writer.Write(*frame->image);
  writer.Finish();
}

/// The page of the operating room in the whole window, as a person sees and uses it.
class Tour {
 public:
  Tour(GuiDriver* gui, const QString& output) : gui_(gui), output_(output) {
    gui_->Window()->ShowPage("intraoperative");
    page_ = gui_->Window()->findChild<QWidget*>("intraoperativePage");
    if (!page_) qFatal("there is no module for the operating room");
  }
  template <class T>
  T* Find(const QString& name) const {
    T* found = page_->findChild<T*>(name);
    if (!found) qFatal("no widget %s", qPrintable(name));
    return found;
  }
  void Click(const QString& name) const {
    QTest::mouseClick(Find<QWidget>(name), Qt::LeftButton);
    QTest::qWait(300);
  }
  void Type(const QString& name, const QString& text) const {
    auto* line = Find<QLineEdit>(name);
    line->setFocus();
    line->clear();
    QTest::keyClicks(line, text);
    QTest::keyClick(line, Qt::Key_Return);
  }
  void Key(Qt::Key key) const {
    QTest::keyClick(Find<QWidget>("overlay_view"), key);
    QTest::qWait(600);
  }
  /// @return false, with a word, where it does not come
  template <class F>
  bool Await(const char* what, F condition, int timeout_ms = 60000) const {
    if (QTest::qWaitFor(condition, timeout_ms)) return true;
    std::printf("not seen: %s\n", what);
    return false;
  }
  void Shoot(const QString& name) const {
    QTest::qWait(400);
    const QString file = output_ + "/intraoperative-" + name + ".jpg";
    gui_->Window()->grab().save(file, nullptr, 88);
    std::printf("%s\n", qPrintable(file));
  }
  void CheckIn(const QString& study, const QString& pseudonym) const {
    Type("source", study + "/video.mp4");
    Type("confirmed", pseudonym);
    Await("check-in", [&] { return Find<QWidget>("register")->isEnabled(); });
  }
  QString CutState() const {
    auto* cuts = Find<QTableWidget>("cuts");
    return cuts->rowCount() > 0 && cuts->item(0, 4) ? cuts->item(0, 4)->text() : QString();
  }
  bool VideoEnded() const { return Find<QLabel>("figures")->text().startsWith("video 0/s"); }
  bool At(const char* widget) const { return Find<QWidget>(widget)->isVisible(); }
  /// A stroke over the overlay, in fractions of the view.
  void Stroke(const QPointF& from, const QPointF& to) const {
    auto* view = Find<QWidget>("overlay_view");
    const auto at = [&](double t) {
      const QPointF p = from + (to - from) * t;
      return QPoint(int(p.x() * view->width()), int(p.y() * view->height()));
    };
    QTest::mousePress(view, Qt::LeftButton, {}, at(0));
    for (int i = 1; i <= 12; ++i) {
      QMouseEvent move(QEvent::MouseMove, at(i / 12.0), view->mapToGlobal(at(i / 12.0)),
                       Qt::NoButton, Qt::LeftButton, {});
      QApplication::sendEvent(view, &move);
    }
    QTest::mouseRelease(view, Qt::LeftButton, {}, at(1));
  }

 private:
  GuiDriver* gui_;
  QString output_;
  QWidget* page_ = nullptr;
};

}  // namespace

/// Goes through a session as a person would and takes a picture of every step.
/// IntraoperativeTour STUDY OUTPUT WIDTH HEIGHT dark|light CASE; CASE is made
int main(int argc, char** argv) {
  const QDir here;  // paths on the command line are meant from here
  QTemporaryDir run;
  qputenv("HOME", run.path().toUtf8());  // pictures show no machine's folders
  const auto app = MakeGuiApplication(argc, argv);
  if (!app) return kerf::testing::kNoDisplay;
  if (argc != 7) {
    std::fprintf(stderr, "IntraoperativeTour STUDY OUTPUT WIDTH HEIGHT dark|light CASE\n");
    return 2;
  }
  const QString output = here.absoluteFilePath(argv[2]);
  const QString made = here.absoluteFilePath(argv[6]);
  kerf::testing::PlanStudyCase(here.absoluteFilePath(argv[1]).toStdString(), made.toStdString(),
                               9000);
  QDir(run.path()).mkdir("study");
  Slowed(here.absoluteFilePath(argv[1]) + "/video.mp4", run.filePath("study/video.mp4"));
  QFile::link(made, run.filePath("case"));
  QDir::setCurrent(run.path());
  const QString study = "study", folder = "case";
  const auto pseudonym =
      QString::fromStdString(kerf::CaseFolder::Open(folder.toStdString()).Manifest().pseudonym);

  GuiDriver gui(run.path());
  gui.Window()->resize(atoi(argv[3]), atoi(argv[4]));
  if (QString(argv[5]) == "light") gui.Window()->findChild<QAction*>("darkAction")->trigger();
  gui.Window()->OpenCase(folder);
  gui.Idle();
  Tour tour(&gui, output);

  tour.CheckIn(study, pseudonym);
  tour.Shoot("check-in");
  tour.Click("register");
  tour.Click("hand_mode");
  tour.Click("contour");
  gui.Idle();
  tour.Shoot("exposure");
  tour.Click("given");
  tour.Find<QCheckBox>("hold")->setChecked(true);
  tour.Click("accept_registration");
  tour.Await("proposal", [&] { return tour.CutState() == "proposed"; });
  tour.Shoot("proposed");
  tour.Key(Qt::Key_D);
  tour.Stroke({0.33, 0.4}, {0.36, 0.66});
  tour.Await("drawn", [&] { return tour.Find<QTableWidget>("cuts")->rowCount() > 1; });
  tour.Shoot("drawn");
  tour.Key(Qt::Key_Z);
  tour.Find<QCheckBox>("hold")->setChecked(false);
  tour.Click("stop");
  tour.Await("end", [&] { return tour.At("export"); });

  // Anew, with cuts taken as they come.
  tour.Click("step1");
  tour.CheckIn(study, pseudonym);
  tour.Click("register");
  tour.Click("given");
  tour.Click("accept_registration");
  tour.Await("cut", [&] { return tour.CutState() == "in the model"; });
  tour.Await(
      "end of the video", [&] { return tour.VideoEnded(); }, 90000);
  tour.Key(Qt::Key_3);
  tour.Shoot("full");
  tour.Key(Qt::Key_1);
  tour.Shoot("outline");
  tour.Key(Qt::Key_2);
  tour.Shoot("see-through");
  tour.Key(Qt::Key_3);
  tour.Key(Qt::Key_B);
  tour.Shoot("raw");
  tour.Key(Qt::Key_B);
  tour.Key(Qt::Key_V);
  tour.Shoot("before");
  tour.Key(Qt::Key_V);
  tour.Key(Qt::Key_S);
  tour.Click("stop");
  tour.Await("end", [&] { return tour.At("export"); });
  tour.Click("export");
  gui.Idle(120000);
  tour.Shoot("close");
  tour.Click("play_session");
  gui.Idle();
  auto* state = tour.Find<QLabel>("review_state");
  tour.Await(
      "playback", [&] { return state->text().startsWith("The same"); }, 120000);
  auto* events = tour.Find<QListWidget>("review_events");
  for (int i = 0; i < events->count(); ++i)
    if (events->item(i)->text().contains("cut applied")) {
      QTest::mouseClick(events->viewport(), Qt::LeftButton, {},
                        events->visualItemRect(events->item(i)).center());
      break;
    }
  for (int i = 0; i < 15; ++i) tour.Key(Qt::Key_Right);
  tour.Shoot("review");
  gui.Abandon();
  return 0;
}
