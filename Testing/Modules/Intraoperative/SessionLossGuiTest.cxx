// What a session loses and what it does not: the source pulled, the registration stuck, the process
// killed. With real events.
#include <QFile>
#include <QProcess>
#include <QScopeGuard>
#include <atomic>
#include <csignal>
#include <set>

#include "Adapters/OpenCv/LucasKanadeTracker.h"
#include "Adapters/OpenCv/VideoSource.h"
#include "CaseIO/JournalRead.h"
#include "GuiScene.h"
#include "MjpegServer.h"
#include "Pipelines/SessionPlayback.h"

using namespace kerf;
using namespace kerf::testing;
namespace fs = std::filesystem;

namespace {

constexpr char kCrash[] = "--run-and-be-killed";

/// The phantom's first pictures, to and fro: nothing is cut in them.
std::vector<Image> FirstPictures() {
  std::vector<Image> pictures;
  const auto video = OpenVideo(std::string(KERF_TEST_PHANTOM) + "/video.mp4");
  for (int i = 0; i < 12; ++i) pictures.push_back(*video->Next()->image);
  for (int i = 10; i > 0; --i) pictures.push_back(pictures[i]);
  return pictures;
}

/// Optical flow that is stuck while `stuck` is set.
class StickingTracker : public FeatureTracker {
 public:
  explicit StickingTracker(const std::atomic<bool>* stuck) : stuck_(stuck) {}
  FeatureSet Detect(const Frame& frame, const Image& mask, int wanted) override {
    return flow_->Detect(frame, mask, wanted);
  }
  void Track(const Frame& frame, FeatureSet* features) override {
    while (*stuck_) std::this_thread::sleep_for(std::chrono::milliseconds(5));
    flow_->Track(frame, features);
  }

 private:
  const std::atomic<bool>* stuck_;
  std::unique_ptr<FeatureTracker> flow_ = MakeFeatureTracker({});
};

// A white square in the rim tells pictures apart: the n-th one has it in the (n % kPlaces)-th
// place.
constexpr int kPlaces = 20, kSquare_px = 24;

Image Stamped(Image picture, int n) {
  const int x0 = 40 + kSquare_px * (n % kPlaces);
  for (int y = picture.height - kSquare_px; y < picture.height; ++y)
    std::fill_n(picture.data.begin() + 3 * (std::size_t(y) * picture.width + x0), 3 * kSquare_px,
                std::uint8_t(255));
  return picture;
}

int PlaceIn(const QImage& picture) {
  for (int place = 0; place < kPlaces; ++place)
    if (!picture.isNull() && qGray(picture.pixel(40 + kSquare_px * place + kSquare_px / 2,
                                                 picture.height() - kSquare_px / 2)) > 200)
      return place;
  return -1;
}

/// The other process: runs until a cut is in the model, says how far it came, and is killed.
int RunAndBeKilled(const QString& case_folder) {
  Page page;
  if (!page.BeginSession(case_folder, QString(KERF_TEST_PHANTOM) + "/video.mp4")) return 1;
  const auto cut = [&] {
    const auto latest = page.Latest();
    return latest && !latest->cuts.empty() && latest->cuts[0].state == CutItem::State::Applied &&
           latest->frame.index > latest->cuts[0].frame + 5;
  };
  if (!QTest::qWaitFor(cut, 60000)) return 2;
  std::printf("%d\n", page.Latest()->frame.index);
  std::fflush(stdout);
  std::raise(SIGKILL);
  return 0;
}

/// Pictures of the window for whoever looks at them: KERF_GUI_PICTURES names a folder.
void Keep(Page* page, const QString& name) {
  const QString folder = qEnvironmentVariable("KERF_GUI_PICTURES");
  if (!folder.isEmpty()) page->widget->grab().save(folder + "/intraoperative-" + name + ".png");
}

}  // namespace

class SessionLossGuiTest : public QObject {
  Q_OBJECT

 private slots:
  void initTestCase() {
    case_ = QString::fromStdString(
        PlanStudyCase(KERF_TEST_PHANTOM, folder_.path().toStdString() + "/case", 3000));
  }
  void APulledStreamSwitchesTheOverlayOffAndComesBack();
  void AStuckRegistrationIsSaidAndTheNewestPictureShown();
  void KilledInTheMiddleAndTakenUpAgain();

 private:
  QTemporaryDir folder_;
  QString case_;
};

void SessionLossGuiTest::APulledStreamSwitchesTheOverlayOffAndComesBack() {
  const std::vector<Image> pictures = FirstPictures();
  MjpegServer camera([&](int n) { return pictures[n % pictures.size()]; });

  Page page;
  page.widget->OpenCase(case_);
  page.Type("source", QString::fromStdString(camera.Url()), true);
  page.Type("confirmed", QString::fromStdString(page.widget->Desk().Pseudonym()));
  QTRY_VERIFY2_WITH_TIMEOUT(page.Find<QPushButton>("register")->isEnabled(),
                            qPrintable(page.ChecksText()), 20000);
  page.Click("register");
  page.Click("accept_registration");
  QCOMPARE(page.widget->CurrentStep(), qKerfIntraoperativeWidget::Run);
  QTRY_VERIFY_WITH_TIMEOUT(page.Latest() && page.Latest()->gate == GateState::Green, 20000);
  auto* lamp = page.Find<QLabel>("lamp");

  camera.SetSilent(true);
  QTRY_VERIFY_WITH_TIMEOUT(page.Latest()->gate == GateState::Off, 10000);
  QTRY_VERIFY2(lamp->text().contains("frozen") || lamp->text().contains("No more pictures"),
               qPrintable(lamp->text()));
  QTRY_VERIFY(lamp->text().contains("OVERLAY OFF"));
  QTRY_VERIFY_WITH_TIMEOUT(page.Latest()->needs_confirmation, 10000);
  QTest::qWait(200);
  QVERIFY(!page.Find<QPushButton>("confirm")->isVisible());  // there is nothing to look at
  camera.SetSilent(false);
  // The pictures are back, the overlay waits for the surgeon's word.
  QTRY_VERIFY_WITH_TIMEOUT(page.Latest()->source.Usable(), 20000);
  QTRY_VERIFY2(lamp->text().contains("confirm"), qPrintable(lamp->text()));
  QTRY_VERIFY(page.Find<QPushButton>("confirm")->isVisible());
  page.Key(Qt::Key_C);
  QTRY_VERIFY_WITH_TIMEOUT(page.Latest()->gate != GateState::Off, 10000);

  camera.Close();
  QTRY_VERIFY_WITH_TIMEOUT(page.Latest()->source.kind == SourceState::Kind::Lost, 10000);
  QTRY_VERIFY2(lamp->text().contains("Trying again"), qPrintable(lamp->text()));
  camera.Open();
  QTRY_VERIFY_WITH_TIMEOUT(page.Latest()->source.Usable(), 20000);
  QVERIFY(page.Latest()->source.reconnects >= 1);

  // A cut drawn while no picture comes, and none comes any more.
  page.Key(Qt::Key_C);
  camera.SetSilent(true);
  QTRY_VERIFY_WITH_TIMEOUT(page.Latest()->gate == GateState::Off, 10000);
  page.Key(Qt::Key_D);
  page.Drag({330, 340}, {330, 200});
  QTRY_VERIFY_WITH_TIMEOUT(page.Latest()->cuts.size() == 1, 10000);
  page.Click("stop");
  QTRY_COMPARE_WITH_TIMEOUT(page.widget->CurrentStep(), qKerfIntraoperativeWidget::Close, 20000);
  const fs::path session = page.widget->Desk().SessionPath();
  QVERIFY(ReadSession(session.string()).finished);
  QVERIFY(fs::exists(session / "frames/000000.jpg"));
  std::multiset<std::string> events;
  for (const JournalEntry& entry : ReadJournal((session / "journal.jsonl").string()))
    events.insert(entry.event);
  // A busy worker may see two changes of the source as one.
  QVERIFY(events.count("source lost") >= 1 && events.count("source running") >= 1);
  QVERIFY(events.count("registration confirmed") >= 1);
  page.Click("play_session");
  SessionPlayback* playback = page.widget->Playback();
  const int last = playback->FrameCount() - 1;
  QCOMPARE(last, int(ReadRecordedFrames(session.string()).size()));  // one more than recorded
  QTRY_VERIFY2_WITH_TIMEOUT(playback->Ready() == last + 1 || !playback->Problem().empty(),
                            playback->Problem().c_str(), 120000);
  QCOMPARE(playback->Problem(), std::string());
  QVERIFY(playback->At(last - 1)->cuts.empty());
  QCOMPARE(playback->At(last)->cuts.size(), std::size_t(1));
  page.Click("step1");
  QVERIFY2(page.problems.isEmpty(), qPrintable(page.problems.join("\n")));
  fs::remove_all(session);
}

void SessionLossGuiTest::AStuckRegistrationIsSaidAndTheNewestPictureShown() {
  const std::vector<Image> pictures = FirstPictures();
  MjpegServer camera([&](int n) { return Stamped(pictures[n % pictures.size()], n); });
  std::atomic<bool> stuck{false};
  Page page;
  const auto freed = qScopeGuard([&] { stuck = false; });  // whatever fails, the session can end
  page.widget->Desk().SetTrackerMaker([&] { return std::make_unique<StickingTracker>(&stuck); });
  page.widget->OpenCase(case_);
  page.widget->OpenSource(QString::fromStdString(camera.Url()));
  QTRY_VERIFY_WITH_TIMEOUT(page.widget->Desk().Newest().has_value(), 20000);
  page.widget->StartWithGivenPose();
  QCOMPARE(page.widget->CurrentStep(), qKerfIntraoperativeWidget::Run);
  auto* lamp = page.Find<QLabel>("lamp");
  QTRY_VERIFY_WITH_TIMEOUT(lamp->text().contains("OVERLAY OK"), 20000);
  page.widget->SetRawBeside(true);

  // Whether `view` goes on through pictures while nothing is registered.
  const auto goes_on = [&](qKerfVideoView* view) {
    std::set<int> places;
    const auto seen = [&] { return places.insert(PlaceIn(view->Picture())), places.size() > 6; };
    return QTest::qWaitFor(seen, 20000) && places.count(-1) == 0;
  };
  const auto off_the_picture = [&] {  // the middle, without the overlay's words
    const QRect middle(150, 120, 660, 330);
    const auto shown = page.widget->Shown();
    return Difference(page.widget->View()->Picture().copy(middle),
                      ToQImage(*shown->frame.image).copy(middle));
  };
  stuck = true;
  QTRY_VERIFY2_WITH_TIMEOUT(lamp->text().contains("OVERLAY OFF: registration behind"),
                            qPrintable(lamp->text()), 20000);
  const int registered = page.Latest()->frame.index;
  const double registered_s = page.Latest()->frame.time_s;
  QVERIFY(goes_on(page.widget->View()));
  QVERIFY(goes_on(page.widget->RawView()));
  QTRY_COMPARE(off_the_picture(), 0.0);
  QTRY_VERIFY(!page.Find<QLabel>("figures")->text().contains("registered"));
  Keep(&page, "behind");
  // The overlay switched off by hand: the newest, too.
  page.Key(Qt::Key_O);
  QVERIFY(goes_on(page.widget->View()));
  page.Key(Qt::Key_O);
  // Pictures that are kept meanwhile are named by what is in them, not by what is registered.
  const fs::path session = page.widget->Desk().SessionPath();
  const auto kept = [&] {
    std::vector<std::string> names;
    for (const JournalEntry& entry : ReadJournal((session / "journal.jsonl").string()))
      if (entry.event == "snapshot") names.push_back(*entry.Text("file"));
    return names;
  };
  page.Click("snapshot");
  page.Key(Qt::Key_O);
  QVERIFY(goes_on(page.widget->View()));
  page.Click("snapshot");
  page.Key(Qt::Key_O);
  QCOMPARE(page.Latest()->frame.index, registered);
  QCOMPARE(page.Latest()->gate, GateState::Green);  // as it was then: what is shown is not that

  // Nobody knows what happened in so long a time: the overlay waits for the surgeon's word.
  const auto hung = [&] {
    return page.widget->Desk().Newest()->captured - page.Latest()->captured >
           std::chrono::milliseconds(1600);
  };
  QTRY_VERIFY_WITH_TIMEOUT(hung(), 10000);
  stuck = false;
  QTRY_VERIFY2_WITH_TIMEOUT(lamp->text().contains("confirm"), qPrintable(lamp->text()), 20000);
  QTRY_VERIFY(page.Find<QPushButton>("confirm")->isVisible());
  QTest::qWait(300);
  QVERIFY2(lamp->text().contains("OVERLAY OFF"), qPrintable(lamp->text()));
  page.Key(Qt::Key_C);
  QTRY_VERIFY2_WITH_TIMEOUT(lamp->text().contains("OVERLAY OK"), qPrintable(lamp->text()), 20000);
  QTRY_VERIFY(off_the_picture() > 0.01);
  page.Click("stop");
  QTRY_COMPARE_WITH_TIMEOUT(page.widget->CurrentStep(), qKerfIntraoperativeWidget::Close, 20000);
  QCOMPARE(kept().size(), std::size_t(2));
  for (const std::string& name : kept()) {
    QVERIFY2(name.rfind("time_", 0) == 0 && fs::exists(session / "snapshots" / name), name.c_str());
    QVERIFY2(std::atof(name.substr(5).c_str()) > registered_s + 0.4, name.c_str());
  }
  QVERIFY(kept()[0] < kept()[1]);
  QFile report(QString::fromStdString((session / "report.html").string()));
  QVERIFY(report.open(QIODevice::ReadOnly));
  QVERIFY(report.readAll().count("s, not registered") >= 2);
  std::multiset<std::string> events;
  for (const JournalEntry& entry : ReadJournal((session / "journal.jsonl").string()))
    events.insert(entry.event);
  QVERIFY(events.count("confirmation needed") >= 1);
  QVERIFY(events.count("registration confirmed") >= 1);
  QVERIFY(events.count("registration behind") >= 1);
  QVERIFY(events.count("registration caught up") >= 1);
  QVERIFY2(page.problems.isEmpty(), qPrintable(page.problems.join("\n")));
  fs::remove_all(session);
}

void SessionLossGuiTest::KilledInTheMiddleAndTakenUpAgain() {
  QProcess child;
  child.start(QCoreApplication::applicationFilePath(), {kCrash, case_});
  QVERIFY(child.waitForFinished(120000));
  QCOMPARE(child.exitStatus(), QProcess::CrashExit);
  const int reached = child.readAllStandardOutput().trimmed().toInt();
  QVERIFY(reached > 0);

  Page page;
  page.UseEveryFrame();
  page.widget->OpenCase(case_);
  const auto unfinished = page.widget->Desk().Unfinished();
  QCOMPARE(unfinished.size(), std::size_t(1));
  QVERIFY(int(ReadRecordedFrames(unfinished[0]).size()) >= reached);
  auto* resume = page.Find<QPushButton>("resume");
  QVERIFY(resume->isVisible());
  // Not before the check-in.
  page.Click("resume");
  QCOMPARE(page.widget->CurrentStep(), qKerfIntraoperativeWidget::CheckIn);
  QCOMPARE(page.problems.size(), 1);
  page.problems.clear();
  QVERIFY(page.TakeUpAgain(QString(KERF_TEST_PHANTOM) + "/video.mp4"));
  QTRY_VERIFY_WITH_TIMEOUT(page.Latest() && !page.Latest()->cuts.empty(), 30000);
  // The cut of then is in the model from the start.
  QVERIFY(page.Latest()->cuts[0].drawn);
  QVERIFY(page.Latest()->cuts[0].state == CutItem::State::Applied);
  page.Click("stop");
  QTRY_COMPARE_WITH_TIMEOUT(page.widget->CurrentStep(), qKerfIntraoperativeWidget::Close, 20000);
  // What was recorded up to the kill is played, and says that it was broken off.
  page.widget->OpenRecorded(QString::fromStdString(unfinished[0]));
  QCOMPARE(page.widget->CurrentStep(), qKerfIntraoperativeWidget::Review);
  QTRY_VERIFY_WITH_TIMEOUT(page.widget->Shown() != nullptr, 30000);
  QVERIFY2(page.problems.isEmpty(), qPrintable(page.problems.join("\n")));
}

int main(int argc, char** argv) {
  if (argc == 3 && QString(argv[1]) == kCrash) {
    if (!DisplayForQt()) return kNoDisplay;
    QApplication app(argc, argv);
    return RunAndBeKilled(argv[2]);
  }
  return RunGuiTest<SessionLossGuiTest>(argc, argv);
}

#include "SessionLossGuiTest.moc"
