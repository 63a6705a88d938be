// What a session loses and what it does not: the source pulled, the process killed. With real
// events.
#include <QProcess>
#include <csignal>
#include <set>

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

void UseEveryFrame(Page* page) {
  CaptureOptions options;
  options.every = true;
  options.paced = false;
  page->widget->Desk().SetCaptureOptions(options);
}

bool BeginSession(Page* page, const QString& case_folder) {
  UseEveryFrame(page);
  page->widget->OpenCase(case_folder);
  page->widget->OpenSource(QString(KERF_TEST_PHANTOM) + "/video.mp4");
  if (!QTest::qWaitFor([&] { return page->widget->Desk().Newest().has_value(); }, 20000))
    return false;
  page->widget->StartWithGivenPose();
  return page->widget->CurrentStep() == qKerfIntraoperativeWidget::Run;
}

/// The other process: runs until a cut is in the model, says how far it came, and is killed.
int RunAndBeKilled(const QString& case_folder) {
  Page page;
  if (!BeginSession(&page, case_folder)) return 1;
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

}  // namespace

class SessionLossGuiTest : public QObject {
  Q_OBJECT

 private slots:
  void initTestCase() {
    case_ = QString::fromStdString(
        PlanStudyCase(KERF_TEST_PHANTOM, folder_.path().toStdString() + "/case", 3000));
  }
  void APulledStreamSwitchesTheOverlayOffAndComesBack();
  void KilledInTheMiddleAndTakenUpAgain();

 private:
  QTemporaryDir folder_;
  QString case_;
};

void SessionLossGuiTest::APulledStreamSwitchesTheOverlayOffAndComesBack() {
  // The phantom's first pictures, to and fro: nothing is cut in them.
  std::vector<Image> pictures;
  const auto video = OpenVideo(std::string(KERF_TEST_PHANTOM) + "/video.mp4");
  for (int i = 0; i < 12; ++i) pictures.push_back(*video->Next()->image);
  for (int i = 10; i > 0; --i) pictures.push_back(pictures[i]);
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
  QTRY_VERIFY(page.Find<QPushButton>("confirm")->isVisible());
  camera.SetSilent(false);
  // The pictures are back, the overlay waits for the surgeon's word.
  QTRY_VERIFY_WITH_TIMEOUT(page.Latest()->source.Usable(), 20000);
  QTRY_VERIFY2(lamp->text().contains("confirm"), qPrintable(lamp->text()));
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

void SessionLossGuiTest::KilledInTheMiddleAndTakenUpAgain() {
  QProcess child;
  child.start(QCoreApplication::applicationFilePath(), {kCrash, case_});
  QVERIFY(child.waitForFinished(120000));
  QCOMPARE(child.exitStatus(), QProcess::CrashExit);
  const int reached = child.readAllStandardOutput().trimmed().toInt();
  QVERIFY(reached > 0);

  Page page;
  UseEveryFrame(&page);
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
  page.Type("source", QString(KERF_TEST_PHANTOM) + "/video.mp4", true);
  page.Type("confirmed", QString::fromStdString(page.widget->Desk().Pseudonym()));
  QTRY_VERIFY2_WITH_TIMEOUT(page.Find<QPushButton>("register")->isEnabled(),
                            qPrintable(page.ChecksText()), 20000);
  page.Click("resume");
  QCOMPARE(page.widget->CurrentStep(), qKerfIntraoperativeWidget::Exposure);
  page.Click("accept_registration");
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
