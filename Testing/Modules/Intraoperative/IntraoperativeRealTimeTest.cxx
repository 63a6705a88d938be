// At the rate of the video: nothing is waited for, what is shown is said. On the phantom and, where
// it is there, on a recorded study.

#include <cmath>

#include "CaseIO/JournalRead.h"
#include "GuiScene.h"
#include "Pipelines/SessionFolder.h"

using namespace kerf;
using namespace kerf::testing;
namespace fs = std::filesystem;

class IntraoperativeRealTimeTest : public QObject {
  Q_OBJECT

 private:
  static std::string Kidney() {
    return qEnvironmentVariable("KERF_CASES", KERF_CASES_DEFAULT).toStdString() + "/kidney-1";
  }
  void Start(Page* page, const std::string& study, const std::string& case_folder) {
    page->widget->OpenCase(QString::fromStdString(case_folder));
    page->widget->OpenSource(QString::fromStdString(OpenStudy(study).video));
    QTRY_VERIFY_WITH_TIMEOUT(page->widget->Desk().Newest().has_value(), 5000);
    page->widget->StartWithGivenPose();
    QCOMPARE(page->widget->CurrentStep(), qKerfIntraoperativeWidget::Run);
  }
  void RunsInRealTime(const std::string& study, int tetrahedra, double seconds) {
    QTemporaryDir folder;
    const std::string planned =
        PlanStudyCase(study, folder.path().toStdString() + "/case", tetrahedra);
    Page page;
    Start(&page, study, planned);
    QTRY_VERIFY_WITH_TIMEOUT(page.Latest() && page.Latest()->gate == GateState::Green, 10000);
    double registered = 0, shown = 0, latency = 0;
    int count = 0;
    QElapsedTimer clock;
    clock.start();
    while (clock.elapsed() < seconds * 1000) {
      QTest::qWait(250);
      if (clock.elapsed() < 1500) continue;  // of a whole second
      registered += page.Latest()->registered_fps;
      shown += page.widget->ShownPerSecond();
      latency += page.widget->Latency_ms();
      ++count;
    }
    qInfo("%d tetrahedra: registered %.1f/s, shown %.1f/s, latency %.0f ms, dropped %d",
          page.Latest()->tetrahedra, registered / count, shown / count, latency / count,
          page.Latest()->source.dropped);
    QVERIFY(page.Latest()->frame.index > 10);
    QVERIFY(page.Latest()->gate != GateState::Off);
    QVERIFY(page.Find<QLabel>("figures")->text().contains("latency"));
    QVERIFY(page.Find<QLabel>("figures")->text().contains("dropped"));
    QVERIFY(Difference(page.widget->View()->Picture(), ToQImage(*page.Latest()->frame.image)) >
            0.005);
    page.Click("stop");
    QTRY_COMPARE_WITH_TIMEOUT(page.widget->CurrentStep(), qKerfIntraoperativeWidget::Close, 20000);
    QVERIFY(page.problems.isEmpty());
    SayWhatWasSkipped(page.widget->Desk().SessionPath());
  }
  /// From the first second on: before that the features are found and the model is set up.
  void SayWhatWasSkipped(const std::string& session) {
    int registered = 0, pictures = 0, last = -1, longest = 0;
    for (const RecordedFrame& frame : ReadRecordedFrames(session)) {
      if (frame.time_s > 1.0) {
        const int gap = frame.source_frame - last;
        ++registered;
        pictures += gap;
        longest = std::max(longest, gap - 1);
      }
      last = frame.source_frame;
    }
    qInfo("registered %d of %d pictures after the first second, at most %d skipped in a row",
          registered, pictures, longest);
    QVERIFY(registered > 0);
    for (const JournalEntry& entry : ReadJournal(session + "/journal.jsonl"))
      if (entry.event.rfind("registration ", 0) == 0 || entry.event == "confirmation needed")
        qInfo("%.2f s, frame %d: %s", entry.time_s, entry.frame, entry.event.c_str());
  }

 private slots:
  void ThePhantom() { RunsInRealTime(KERF_TEST_PHANTOM, 4000, 4.0); }

  void ARecordedKidney() {
    if (!fs::exists(Kidney())) QSKIP("no kidney-1 among the cases (KERF_CASES)");
    RunsInRealTime(Kidney(), 15000, 6.0);
  }

  /// Every picture, with hands: check-in, registration, the cut that is found, its rejection and
  /// its return, export.
  void ARecordedKidneyFromCheckInToExport() {
    if (!fs::exists(Kidney())) QSKIP("no kidney-1 among the cases (KERF_CASES)");
    QTemporaryDir folder;
    const std::string planned =
        PlanStudyCase(Kidney(), folder.path().toStdString() + "/case", 8000);
    Page page;
    CaptureOptions options;
    options.every = true;
    options.paced = false;
    page.widget->Desk().SetCaptureOptions(options);
    page.widget->OpenCase(QString::fromStdString(planned));
    page.Type("source", QString::fromStdString(OpenStudy(Kidney()).video), true);
    page.Type("confirmed", QString::fromStdString(page.widget->Desk().Pseudonym()));
    QTRY_VERIFY2_WITH_TIMEOUT(page.Find<QPushButton>("register")->isEnabled(),
                              qPrintable(page.ChecksText()), 20000);
    page.Click("register");
    page.Click("given");
    page.Click("accept_registration");
    QCOMPARE(page.widget->CurrentStep(), qKerfIntraoperativeWidget::Run);
    const auto applied = [&] {
      return !page.Latest()->cuts.empty() &&
             page.Latest()->cuts[0].state == CutItem::State::Applied;
    };
    QTRY_VERIFY_WITH_TIMEOUT(page.Latest() && page.Latest()->frame.index > 5, 20000);
    const int uncut = page.Latest()->tetrahedra;
    QTRY_VERIFY_WITH_TIMEOUT(applied(), 120000);
    QVERIFY(page.Latest()->frame.index > 60);  // not before it was made
    QTRY_VERIFY_WITH_TIMEOUT(page.Latest()->source.kind == SourceState::Kind::Ended, 120000);
    QTest::qWait(300);
    if (page.Latest()->needs_confirmation) page.Key(Qt::Key_C);
    QTRY_VERIFY(page.Latest()->gate != GateState::Off);
    QTRY_VERIFY(Difference(page.widget->View()->Picture(), ToQImage(*page.Latest()->frame.image)) >
                0.01);
    QVERIFY(std::isfinite(page.Latest()->margin_mm));
    page.Key(Qt::Key_R);
    QTRY_VERIFY_WITH_TIMEOUT(!applied() && page.Latest()->tetrahedra == uncut, 10000);
    page.Key(Qt::Key_Z);
    QTRY_VERIFY_WITH_TIMEOUT(applied() && page.Latest()->tetrahedra > uncut, 10000);
    page.Click("stop");
    QTRY_COMPARE_WITH_TIMEOUT(page.widget->CurrentStep(), qKerfIntraoperativeWidget::Close, 20000);
    QVERIFY(page.Exports());
    QVERIFY2(page.problems.isEmpty(), qPrintable(page.problems.join("\n")));
  }
};

int main(int argc, char** argv) { return RunGuiTest<IntraoperativeRealTimeTest>(argc, argv); }

#include "IntraoperativeRealTimeTest.moc"
