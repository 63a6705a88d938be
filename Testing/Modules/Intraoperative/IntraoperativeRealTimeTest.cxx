// At the rate of the video: nothing is waited for, what is shown is said. On the phantom and, where
// it is there, on a recorded study.

#include <cmath>

#include "GuiScene.h"

using namespace kerf;
using namespace kerf::testing;
namespace fs = std::filesystem;

class IntraoperativeRealTimeTest : public QObject {
  Q_OBJECT

 private:
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
  }

 private slots:
  void ThePhantom() { RunsInRealTime(KERF_TEST_PHANTOM, 4000, 4.0); }

  void ARecordedKidney() {
    const std::string study =
        qEnvironmentVariable("KERF_CASES", KERF_CASES_DEFAULT).toStdString() + "/kidney-1";
    if (!fs::exists(study)) QSKIP("no kidney-1 among the cases (KERF_CASES)");
    RunsInRealTime(study, 15000, 6.0);
  }
};

int main(int argc, char** argv) { return RunGuiTest<IntraoperativeRealTimeTest>(argc, argv); }

#include "IntraoperativeRealTimeTest.moc"
